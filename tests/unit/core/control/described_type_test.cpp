// Type descriptions of endpoints: ours are such that others accept them, theirs are not believed.
#include "core/control/described_type.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/type_shape.h"
#include "sft/type_support.h"

namespace sft::core {
namespace {

using namespace detail;

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::PointCloud2;
using ::testing::HasSubstr;

template <class T>
Endpoint endpoint_of() {
  Endpoint e;
  e.node = "lidar";
  e.topic = "points";
  e.type_name = TypeTable<T>::type.name;
  e.type_hash = structure_hash(TypeTable<T>::type);
  e.type_description = announced_description(TypeTable<T>::type);
  return e;
}

TEST(DescribedTypeTest, IsTheOneThatWasAnnounced) {
  const auto type = described_type(endpoint_of<PointCloud2>());
  ASSERT_TRUE(type) << type.error().message;
  EXPECT_EQ(type->hash(), structure_hash(TypeTable<PointCloud2>::type));
}

TEST(DescribedTypeTest, OfAnotherHashOrNameIsMalformed) {
  Endpoint e = endpoint_of<PointCloud2>();
  e.type_hash ^= 1;
  EXPECT_EQ(described_type(e).error().code, Errc::malformed);
  e = endpoint_of<PointCloud2>();
  e.type_name = "sensor_msgs::msg::PointCloud";
  EXPECT_EQ(described_type(e).error().code, Errc::malformed);
  e = endpoint_of<PointCloud2>();
  e.type_description = endpoint_of<Odometry>().type_description;
  const auto type = described_type(e);
  ASSERT_FALSE(type);
  EXPECT_THAT(type.error().message, HasSubstr("node 'lidar', topic 'points'"));
}

TEST(DescribedTypeTest, ThatIsNoDescriptionIsMalformedAndThatIsNoneIsUnavailable) {
  Endpoint e = endpoint_of<PointCloud2>();
  e.type_description.pop_back();
  EXPECT_EQ(described_type(e).error().code, Errc::malformed);
  e.type_description.clear();
  EXPECT_EQ(described_type(e).error().code, Errc::unavailable);
}

TEST(DescribedTypeTest, ATypeBeyondTheLimitsIsAnnouncedWithoutDescription) {
  std::vector<std::string> names;
  for (int i = 0; i < 1000; ++i) names.push_back("member_" + std::to_string(i));
  std::vector<Member> members;
  for (const std::string& name : names) members.push_back({.name = name, .kind = Kind::uint8});
  EXPECT_TRUE(announced_description(StructType("pkg::Large", members)).empty());
  members.resize(500);
  EXPECT_FALSE(announced_description(StructType("pkg::Small", members)).empty());
}

}  // namespace
}  // namespace sft::core
