// Type descriptions of endpoints. Other nodes accept the descriptions of this node. Descriptions of other
// nodes are checked before use.
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
  e.type_description = announced_description(TypeTable<T>::type).value();
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

/// A type of `members` members. Each member occupies 25 bytes of the description.
class Wide {
 public:
  explicit Wide(std::size_t members) {
    for (std::size_t i = 0; i < members; ++i)
      names_.push_back("a_member_of_number_" + std::to_string(1000 + i));
    for (const std::string& name : names_) members_.push_back({.name = name, .kind = Kind::uint8});
  }
  StructType type() const { return {"pkg::Wide", members_}; }

 private:
  std::vector<std::string> names_;
  std::vector<Member> members_;
};

TEST(DescribedTypeTest, ATypeOfNearly64KibIsAnnouncedWithItsDescriptionAndALargerOneIsNot) {
  const Wide fits(2600), does_not(2700);
  const auto description = announced_description(fits.type());
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_GT(description->size(), 60'000U);
  const auto refused = announced_description(does_not.type());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::limit_exceeded);
  EXPECT_THAT(refused.error().message, HasSubstr("65536"));
}

}  // namespace
}  // namespace sft::core
