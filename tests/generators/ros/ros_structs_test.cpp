// ROS 2's rosidl has made structs of all messages that SFT installs, and of the messages with which ROS 2
// tests its own compilers. SFT encodes these structs as ROS 2's own typesupport does, and decodes into
// them.
#include <gtest/gtest.h>

#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "every_struct.h"
#include "sft/detail/decode.h"
#include "sft/detail/encode.h"
#include "sft/detail/struct_in.h"
#include "tests/generators/ros/introspected.h"
#include "tests/support/encoded.h"
#include "tests/support/random_value.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using namespace detail;

/// One message as a generated struct and as a struct of ROS 2.
struct Contestant {
  std::string name;
  const TypeSupport* type;
  const StructType* in_ros;
  const RosMembers* ros;
  std::shared_ptr<void> (*make)();
  std::shared_ptr<void> (*make_of_ros)();
};

void PrintTo(const Contestant& c, std::ostream* out) { *out << c.name; }

template <class T>
std::shared_ptr<void> make() {
  return std::make_shared<T>();
}

template <class T, class S>
Contestant contestant(const char* package, const char* name) {
  const rosidl_message_type_support_t* const ros =
      rosidl_typesupport_introspection_cpp::get_message_type_support_handle<S>();
  return {std::string(package) + "_" + name,
          &type_support<T>(),
          &StructIn<T, S>::type,
          static_cast<const RosMembers*>(ros->data),
          make<T>,
          make<S>};
}

const std::vector<Contestant>& contestants() {
#define CONTESTANT(package, name) \
  contestant<::my::sft_msgs::package::msg::name, ::package::msg::name>(#package, #name),
  static const std::vector<Contestant> all{EACH_ROS_STRUCT(CONTESTANT)};
#undef CONTESTANT
  return all;
}

class EveryRosStruct : public RandomTest, public ::testing::WithParamInterface<Contestant> {
 protected:
  const Contestant& c = GetParam();
  const FieldMask full = c.type->full();
  RandomValues values{random};

  std::shared_ptr<void> random_message() {
    auto message = c.make();
    values.fill(c.type->type(), message.get());
    return message;
  }
  std::shared_ptr<void> ros_struct_of(std::span<const std::byte> body) {
    auto message = c.make_of_ros();
    deserialize_by_ros(*c.ros, body, message.get());
    return message;
  }
  std::vector<std::byte> as_ros_encodes(const void* message) const {
    return serialized_by_ros(*c.ros, message, 1 << 18);
  }
  std::span<const std::uint32_t> index_of(Encoded& encoded) { return {encoded.index(), encoded.slots()}; }
  std::uint64_t rounds() const { return test_rounds(10); }
};

TEST_P(EveryRosStruct, IsEncodedAsRosEncodesIt) {
  for (std::uint64_t round = 0; round < rounds(); ++round) {
    const auto message = random_message();
    Encoded ours(c.type->type(), message.get(), full);
    const auto theirs = ros_struct_of(ours.bytes());
    ASSERT_EQ(as_ros_encodes(theirs.get()), ours.bytes());
    Encoded of_theirs(*c.in_ros, theirs.get(), full);
    ASSERT_EQ(of_theirs.bytes(), ours.bytes());
    ASSERT_TRUE(std::ranges::equal(index_of(of_theirs), index_of(ours)));
  }
}

TEST_P(EveryRosStruct, IsFilledWhateverItHeldBefore) {
  for (std::uint64_t round = 0; round < rounds(); ++round) {
    const Encoded ours(c.type->type(), random_message().get(), full);
    const auto theirs = ros_struct_of(Encoded(c.type->type(), random_message().get(), full).bytes());
    ASSERT_EQ(decode(ours.state(), *c.in_ros, theirs.get()), WalkStatus::ok);
    ASSERT_EQ(as_ros_encodes(theirs.get()), ours.bytes());
  }
}

TEST_P(EveryRosStruct, ObeysMasksAsAGeneratedStructDoes) {
  for (std::uint64_t round = 0; round < rounds(); ++round) {
    const auto message = random_message();
    const auto theirs = ros_struct_of(Encoded(c.type->type(), message.get(), full).bytes());
    const FieldMask mask = c.type->closed(values.mask(c.type->leaves()));
    Encoded ours(c.type->type(), message.get(), mask);
    Encoded of_theirs(*c.in_ros, theirs.get(), mask);
    ASSERT_EQ(of_theirs.bytes(), ours.bytes());
    ASSERT_TRUE(std::ranges::equal(index_of(of_theirs), index_of(ours)));

    const auto filled = c.make_of_ros();
    ASSERT_EQ(decode(ours.state(), *c.in_ros, filled.get()), WalkStatus::ok);
    ASSERT_EQ(Encoded(*c.in_ros, filled.get(), mask).bytes(), ours.bytes());
  }
}

INSTANTIATE_TEST_SUITE_P(, EveryRosStruct, ::testing::ValuesIn(contestants()),
                         [](const auto& param_info) { return param_info.param.name; });

TEST(RosStructs, WhosePackingIsThatOfGeneratedOnesAreCopiedAtOnce) {
  using Point = StructIn<::my::sft_msgs::geometry_msgs::msg::Point, ::geometry_msgs::msg::Point>;
  EXPECT_TRUE(Point::type.is_packed_in_memory);
}

}  // namespace
}  // namespace sft::test
