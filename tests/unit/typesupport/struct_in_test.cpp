// Messages in structs of the program that have the members of a generated type, in other vectors.
#include "sft/detail/struct_in.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <proof.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "sft/detail/decode.h"
#include "sft/detail/encode_fault.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

/// A vector with a bound that throws, and without a data() that could be called, as ROS 2's.
template <class E, std::size_t Bound, class Allocator = std::allocator<E>>
class BoundedVector : protected std::vector<E, Allocator> {
  using Base = std::vector<E, Allocator>;

 public:
  using Base::begin;
  using Base::empty;
  using Base::end;
  using Base::front;
  using Base::size;
  using typename Base::iterator;
  using typename Base::reference;
  using typename Base::value_type;
  using Base::operator[];
  void resize(std::size_t n) {
    if (n > Bound) throw std::length_error("beyond the bound");
    Base::resize(n);
  }
};

struct Pair {
  std::uint8_t a = 0;
  double b = 0;
};

/// The members of proof::Bounded. FlagsBound is the bound of the C++ type, that of the message is 9.
template <std::size_t FlagsBound = 9>
struct BoundedOfRos {
  std::string name;
  std::array<std::string, 2> names;
  std::uint8_t between = 0;
  std::vector<std::string> tags;
  BoundedVector<double, 3> doubles;
  BoundedVector<Pair, 3> pairs;
  BoundedVector<bool, FlagsBound> flags;
};

template <class S>
constexpr const StructType& type_of = StructIn<proof::Bounded, S>::type;
const FieldMask full = type_support<proof::Bounded>().full();

proof::Bounded some_message() {
  return {.name = "name",
          .names = {"a", "b"},
          .between = 7,
          .tags = {"x", "", "z"},
          .doubles = {1.5, 2.5},
          .pairs = {{1, 2}, {3, 4}},
          .flags = {1, 0, 1, 1, 0}};
}

TEST(StructInTest, IsFilledFromASampleAndEncodedToTheSameBytes) {
  const test::Encoded sample(some_message());
  BoundedOfRos<> message;
  ASSERT_EQ(decode(sample.state(), type_of<BoundedOfRos<>>, &message), WalkStatus::ok);
  EXPECT_EQ(message.tags.at(2), "z");
  EXPECT_EQ(message.doubles.front(), 1.5);
  EXPECT_TRUE(message.flags[3]);
  EXPECT_EQ(test::Encoded(type_of<BoundedOfRos<>>, &message, full).bytes(), sample.bytes());
}

TEST(StructInTest, EmptyVectorsAreEncodedAndFilled) {
  const test::Encoded sample(proof::Bounded{});
  BoundedOfRos<> message;
  message.doubles.resize(2);
  message.flags.resize(2);
  ASSERT_EQ(decode(sample.state(), type_of<BoundedOfRos<>>, &message), WalkStatus::ok);
  EXPECT_TRUE(message.doubles.empty() && message.flags.empty());
  EXPECT_EQ(test::Encoded(type_of<BoundedOfRos<>>, &message, full).bytes(), sample.bytes());
}

TEST(StructInTest, AByteThatIsNoBooleanIsRefused) {
  test::Encoded sample(some_message());
  sample.body()[sample.state().body_bytes - 1] = std::byte{2};
  BoundedOfRos<> message;
  EXPECT_EQ(decode(sample.state(), type_of<BoundedOfRos<>>, &message), WalkStatus::bad_boolean);
}

TEST(StructInTest, ANarrowerBoundOfTheStructIsAnErrorAndThrowsNothing) {
  const test::Encoded sample(some_message());
  BoundedOfRos<4> message;
  EXPECT_EQ(decode(sample.state(), type_of<BoundedOfRos<4>>, &message), WalkStatus::bad_length);
}

TEST(StructInTest, AVectorBeyondTheBoundOfTheMessageIsNamedWithBoth) {
  BoundedOfRos<20> message;
  message.flags.resize(10);
  const auto fault = [&] {
    return encode_fault(type_support<proof::Bounded>(), {type_of<BoundedOfRos<20>>, &message}, full,
                        SIZE_MAX);
  };
  EXPECT_EQ(fault(), "'flags' has 10 elements; its bound is 9");
  message.flags.resize(9);
  EXPECT_EQ(fault(), "");
  message.tags.resize(5);
  EXPECT_EQ(fault(), "'tags' has 5 elements; its bound is 4");
}

}  // namespace
}  // namespace sft
