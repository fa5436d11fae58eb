// Types that are generated from .msg files, and the initial values of their owned structs.
#include <gtest/gtest.h>

#include <array>
#include <far_msgs/msg/Plan.hpp>
#include <limits>
#include <test_interface_files/msg/BoundedPlainSequences.hpp>
#include <test_interface_files/msg/Empty.hpp>
#include <test_interface_files/msg/MultiNested.hpp>
#include <test_interface_files/msg/Nested.hpp>
#include <test_interface_files/msg/Strings.hpp>
#include <test_interface_files/srv/Arrays.hpp>
#include <test_interface_files/srv/Empty.hpp>
#include <torture_msgs/msg/Deep.hpp>
#include <torture_msgs/msg/Mixed.hpp>
#include <torture_msgs/msg/Windows.hpp>
#include <type_traits>

#include "sft/detail/decode.h"
#include "tests/support/encoded.h"
#include "tests/support/owned_value.h"
#include "tests/support/random_value.h"

namespace sft {
namespace {

using namespace detail;

namespace interfaces = ::test_interface_files::msg;
namespace services = ::test_interface_files::srv;
namespace torture = ::torture_msgs::msg;

template <class T>
class RoundTrip : public test::RandomTest {};

using Types =
    ::testing::Types<interfaces::Arrays, interfaces::BasicTypes, interfaces::BoundedPlainSequences,
                     interfaces::BoundedSequences, interfaces::Constants, interfaces::Defaults,
                     interfaces::Empty, interfaces::MultiNested, interfaces::Nested, interfaces::Strings,
                     interfaces::UnboundedSequences, services::Arrays::Call, services::Arrays::Reply,
                     services::Empty::Call, services::Empty::Reply, torture::Collections, torture::Deep,
                     torture::Literals, torture::Mixed, torture::UInt8, torture::Windows, torture::Words>;
TYPED_TEST_SUITE(RoundTrip, Types);

TYPED_TEST(RoundTrip, OfRandomValuesGivesThemBack) {
  test::RandomValues values(this->random);
  for (int round = 0; round < 200; ++round) {
    test::OwnedValue sent = test::OwnedValue::of<TypeParam>();
    test::OwnedValue received = test::OwnedValue::of<TypeParam>();
    values.fill(sent.type(), sent.get());
    const test::Encoded encoded(sent.type(), sent.get(), FieldMask::full(leaf_count(sent.type())));
    ASSERT_EQ(decode(encoded.state(), received.type(), received.get()), WalkStatus::ok);
    ASSERT_TRUE(same_value(sent, received)) << "in round " << round;
  }
}

TEST(Defaults, OfSingleValuesInitializeTheOwnedStruct) {
  const interfaces::Defaults d;
  EXPECT_TRUE(d.bool_value);
  EXPECT_EQ(d.byte_value, 50);
  EXPECT_EQ(d.char_value, 100);
  EXPECT_EQ(d.float32_value, 1.125F);
  EXPECT_EQ(d.int64_value, -40000000);
  EXPECT_EQ(d.uint64_value, 50000000U);
}

TEST(Services, NameTheirMessages) {
  static_assert(std::is_same_v<services::Arrays::Request, services::Arrays_Request>);
  static_assert(std::is_same_v<decltype(services::Arrays::Call::request), services::Arrays_Request>);
  static_assert(std::is_same_v<decltype(services::Arrays::Reply::response), services::Arrays_Response>);
  EXPECT_EQ(TypeTable<services::Arrays::Request>::type.name, "test_interface_files::srv::Arrays_Request");
  EXPECT_EQ(services::Arrays::Response().float32_values_default, (std::array{1.125F, 0.F, -1.125F}));
}

TEST(Defaults, OfArraysAndSequencesInitializeTheOwnedStruct) {
  const interfaces::Arrays a;
  EXPECT_EQ(a.bool_values_default, (std::array<std::uint8_t, 3>{0, 1, 0}));
  EXPECT_EQ(a.float32_values_default, (std::array{1.125F, 0.F, -1.125F}));
  EXPECT_EQ(a.string_values_default, (std::array<std::string, 3>{"", "max value", "min value"}));
  const interfaces::UnboundedSequences s;
  EXPECT_EQ(s.int64_values_default, (std::vector{std::int64_t{0}, std::numeric_limits<std::int64_t>::max(),
                                                 std::numeric_limits<std::int64_t>::min()}));
  EXPECT_EQ(s.string_values_default, (std::vector<std::string>{"", "max value", "min value"}));
}

TEST(Defaults, OfStringsAreReadInBothKindsOfQuotes) {
  const interfaces::Strings s;
  EXPECT_EQ(s.string_value, "");
  EXPECT_EQ(s.string_value_default3, "Hello\"world!");
  EXPECT_EQ(s.string_value_default4, "Hello'world!");
  EXPECT_EQ(s.bounded_string_value_default5, "Hello\"world!");
  EXPECT_EQ(interfaces::Strings::STRING_CONST, "Hello world!");
}

TEST(Defaults, AreZeroWhereTheMessageSaysNothing) {
  EXPECT_EQ(interfaces::BasicTypes{}.float64_value, 0.0);
  EXPECT_TRUE(interfaces::UnboundedSequences{}.int64_values.empty());
}

TEST(Constants, AreMembersOfTheStruct) {
  using interfaces::Constants;
  static_assert(std::is_same_v<decltype(Constants::BYTE_CONST), const std::uint8_t>);
  static_assert(std::is_same_v<decltype(Constants::CHAR_CONST), const std::uint8_t>);
  static_assert(Constants::BOOL_CONST && Constants::BYTE_CONST == 50 && Constants::CHAR_CONST == 100);
  static_assert(Constants::FLOAT32_CONST == 1.125F && Constants::INT64_CONST == -40000000);
}

TEST(EmptyMessages, AreOneByteAsInRos) {
  EXPECT_EQ(interfaces::Empty{}.structure_needs_at_least_one_member, 0);
  EXPECT_EQ(test::Encoded(interfaces::Empty{}).bytes(), std::vector(1, std::byte{0}));
}

TEST(Idl, NestsMessagesAndMessagesNestIdl) {
  using torture::Mixed;
  static_assert(std::is_same_v<decltype(Mixed::deep), torture::Deep>);
  static_assert(std::is_same_v<decltype(torture::Deep::plan), far_msgs::msg::Plan>);
  static_assert(std::is_same_v<decltype(Mixed::numbers), std::array<std::int32_t, 22>>);
  const TypeSupport mixed(TypeTable<Mixed>::type);
  EXPECT_TRUE(mixed.find("header.frame_id"));
  EXPECT_TRUE(mixed.find("deep.middles[].inner[].literals.text"));
  EXPECT_TRUE(mixed.find("bytes[].data"));
}

}  // namespace
}  // namespace sft
