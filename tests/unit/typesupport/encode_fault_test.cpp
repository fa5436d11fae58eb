// The errors for values that cannot be encoded. An error names the field, its size and the limit.
#include "sft/detail/encode_fault.h"

#include <gtest/gtest.h>

#include <proof.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using proof::Bounded;
using sensor_msgs::msg::PointCloud2;

constexpr std::size_t no_limit = SIZE_MAX;

template <class T>
std::string fault(const T& value, std::size_t bytes_max = no_limit, const Mask<T>& mask = all<T>,
                  std::span<const Reservation> reservations = {}) {
  const TypeSupport& type = sft::type_support<T>();
  return encode_fault(type, {type.type(), &value}, type.closed(FieldMask(mask)), bytes_max, reservations);
}

TEST(EncodeFaultTest, AMessageThatCanBeEncodedHasNone) {
  EXPECT_EQ(fault(Bounded{}), "");
  EXPECT_EQ(fault(PointCloud2{}), "");
}

TEST(EncodeFaultTest, AStringBeyondItsBoundIsNamedWithBoth) {
  Bounded bounded;
  bounded.name = "123456789";
  EXPECT_EQ(fault(bounded), "'name' has 9 characters; its bound is 8");
}

TEST(EncodeFaultTest, AnElementIsNamedByItsPosition) {
  Bounded bounded;
  bounded.names[1] = "123456";
  EXPECT_EQ(fault(bounded), "'names[1]' has 6 characters; its bound is 5");
  PointCloud2 cloud;
  cloud.fields.resize(3);
  cloud.fields[2].name = std::string("xy\0", 3);
  EXPECT_EQ(fault(cloud), "'fields[2].name' has a NUL behind 2 characters; a string ends at its first one");
}

TEST(EncodeFaultTest, ASequenceBeyondItsBoundIsNamedWithBoth) {
  Bounded bounded;
  bounded.doubles.resize(4);
  EXPECT_EQ(fault(bounded), "'doubles' has 4 elements; its bound is 3");
  bounded.doubles.clear();
  bounded.pairs.resize(5);
  EXPECT_EQ(fault(bounded), "'pairs' has 5 elements; its bound is 3");
}

TEST(EncodeFaultTest, ABooleanThatIsNoneIsNamedWithItsValue) {
  Bounded bounded;
  bounded.flags = {0, 1, 7};
  EXPECT_EQ(fault(bounded), "'flags[2]' is 7; a boolean is 0 or 1");
}

TEST(EncodeFaultTest, WhatIsNotSelectedIsNotLookedAt) {
  Bounded bounded;
  bounded.name = "123456789";
  EXPECT_EQ(fault<Bounded>(bounded, no_limit, Bounded::Field::doubles), "");
}

TEST(EncodeFaultTest, TheLargestFieldOfATooLargeMessageIsNamed) {
  PointCloud2 cloud;
  cloud.data.resize(1000);
  EXPECT_EQ(fault(cloud, 100),
            "the message has 1045 bytes, 1004 of them in 'data'; at most 100 bytes may be sent");
  cloud.data.clear();
  cloud.fields.resize(50);
  for (auto& field : cloud.fields) field.name = std::string(40, 'x');
  EXPECT_NE(fault(cloud, 100).find("2250 of them in 'fields[].name'"), std::string::npos)
      << fault(cloud, 100);
}

TEST(EncodeFaultTest, WhatALoanReservesCounts) {
  const auto reserved = PointCloud2::LoanView<LoanedPlace<PointCloud2>>::reservations({.data = 500});
  EXPECT_EQ(fault(PointCloud2{}, 100, all<PointCloud2>, reserved),
            "the message has 545 bytes, 504 of them in 'data'; at most 100 bytes may be sent");
}

}  // namespace
}  // namespace sft
