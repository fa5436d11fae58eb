// These tests check which values cannot be encoded, which bytes must not be decoded, and which lengths are
// written in addition to the leaves.
#include <gtest/gtest.h>

#include <cstring>
#include <proof.hpp>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <torture.hpp>

#include "sft/detail/decode.h"
#include "sft/detail/sample_format.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::PointCloud2;
using test::Encoded;

template <class T>
EncodeStatus encoding(const T& value, const Mask<T>& mask = all<T>,
                      std::span<const Reservation> reservations = {}) {
  const FieldMask closed = TypeSupport(TypeTable<T>::type).closed(FieldMask(mask));
  return encoded_size(TypeTable<T>::type, &value, closed, reservations).status;
}

TEST(EncodeTest, ANulWithinAStringIsRefused) {
  BatteryState battery;
  battery.location = std::string("a\0b", 3);
  EXPECT_EQ(encoding(battery), EncodeStatus::string_has_nul);
  battery.location = std::string(1, '\0');
  EXPECT_EQ(encoding(battery), EncodeStatus::string_has_nul);
}

TEST(EncodeTest, WhatIsNotSelectedIsNotChecked) {
  BatteryState battery;
  battery.location = std::string(1, '\0');
  EXPECT_EQ(encoding<BatteryState>(battery, ~BatteryState::Field::location), EncodeStatus::ok);
}

TEST(EncodeTest, AStringUpToItsBoundIsAccepted) {
  proof::Bounded bounded;
  bounded.name = "12345678";
  bounded.names[1] = "12345";
  bounded.tags = {"12345678"};
  EXPECT_EQ(encoding(bounded), EncodeStatus::ok);
}

TEST(EncodeTest, AStringBeyondItsBoundIsRefused) {
  proof::Bounded bounded;
  bounded.name = "123456789";
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
  bounded = {};
  bounded.names[1] = "123456";
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
  bounded = {};
  bounded.tags = {"", "123456789"};
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
}

TEST(EncodeTest, ASequenceUpToItsBoundIsAccepted) {
  proof::Bounded bounded;
  bounded.tags.resize(4);
  bounded.doubles.resize(3);
  bounded.pairs.resize(3);
  EXPECT_EQ(encoding(bounded), EncodeStatus::ok);
}

TEST(EncodeTest, ASequenceBeyondItsBoundIsRefused) {
  proof::Bounded bounded;
  bounded.tags.resize(5);
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
  bounded = {};
  bounded.doubles.resize(4);
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
  bounded = {};
  bounded.pairs.resize(4);
  EXPECT_EQ(encoding(bounded), EncodeStatus::too_large);
}

TEST(EncodeTest, BoundsHoldForReservationsToo) {
  const std::size_t doubles = leaf_offset(TypeTable<proof::Bounded>::type, 4);
  EXPECT_EQ(encoding(proof::Bounded{}, all<proof::Bounded>, std::array{Reservation{doubles, 3}}),
            EncodeStatus::ok);
  EXPECT_EQ(encoding(proof::Bounded{}, all<proof::Bounded>, std::array{Reservation{doubles, 4}}),
            EncodeStatus::too_large);
}

TEST(EncodeTest, ABodyOf4GiBOrMoreIsRefused) {
  const std::size_t data = leaf_offset(TypeTable<PointCloud2>::type, 7);
  const auto reserving = [&](std::uint32_t bytes) {
    return encoding(PointCloud2{}, all<PointCloud2>, std::array{Reservation{data, bytes}});
  };
  EXPECT_EQ(reserving(0xFFFF'FF00), EncodeStatus::ok);
  EXPECT_EQ(reserving(0xFFFF'FFF0), EncodeStatus::too_large);
  EXPECT_EQ(reserving(0xFFFF'FFFF), EncodeStatus::too_large);
}

TEST(EncodeTest, PaddingIsZeroWhateverWasInTheMemory) {
  const proof::Misaligned message{.lead = 1, .pairs = {{2, 3}}, .doubles = {4}};
  const Encoded expected(message);
  std::vector<std::byte> body(expected.state().body_bytes, std::byte{0xAA});
  std::vector<std::uint32_t> index(expected.slots());
  encode(TypeTable<proof::Misaligned>::type, &message, FieldMask(all<proof::Misaligned>), body, index);
  EXPECT_EQ(body, expected.bytes());
}

// Collections of booleans are held as bytes. An application may have set such a byte to any value.
TEST(EncodeTest, ABooleanThatIsNoneIsRefusedAsTheReceiverWould) {
  proof::Bounded bounded;
  bounded.flags = {0, 1, 7};
  EXPECT_EQ(encoding(bounded), EncodeStatus::bad_boolean);
  bounded.flags = {0, 1, 1};
  EXPECT_EQ(encoding(bounded), EncodeStatus::ok);
  torture::Arrays arrays;
  arrays.flags = {1, 1, 1, 2};
  EXPECT_EQ(encoding(arrays), EncodeStatus::bad_boolean);
}

/// A valid body. A test changes bytes of the body before it walks or decodes the body.
template <class T>
class Changed {
 public:
  explicit Changed(const T& value) : encoded_(value) {}

  template <class V>
  void put(std::size_t slot, std::size_t behind, V value) {
    std::memcpy(encoded_.body() + encoded_.index()[slot] + behind, &value, sizeof value);
  }

  WalkStatus walked() const {
    std::vector<std::uint32_t> index(encoded_.slots());
    return build_index(encoded_.state(), TypeTable<T>::type, index);
  }
  WalkStatus decoded(T& value) const { return decode(encoded_.state(), TypeTable<T>::type, &value); }

 private:
  Encoded encoded_;
};

TEST(DecodeTest, LengthsBeyondABoundAreRefused) {
  const proof::Bounded valid{.tags = {"a"}, .doubles = {1, 2, 3}, .pairs = {{}, {}, {}}};
  for (const std::size_t slot : {4U, 5U}) {  // the slots of doubles and pairs
    Changed changed(valid);
    changed.put(slot, 0, std::uint32_t{4});
    proof::Bounded value;
    EXPECT_EQ(changed.walked(), WalkStatus::bad_length) << slot;
    EXPECT_EQ(changed.decoded(value), WalkStatus::bad_length) << slot;
  }
}

TEST(DecodeTest, StringsBeyondTheirBoundAreRefused) {
  proof::Bounded longer;
  longer.name = "12345678";
  Changed changed(longer);
  changed.put(0, 0, std::uint32_t{10});  // `name` now includes the padding byte that follows it
  changed.put(0, 4, std::array{'1', '2', '3', '4', '5', '6', '7', '8', '9', '\0'});
  EXPECT_EQ(changed.walked(), WalkStatus::bad_length);
}

// In shared memory, another process may change bytes after the walk.
TEST(DecodeTest, ABooleanThatIsNoneIsRefusedAndDoesNotStayInTheValue) {
  Changed changed(PointCloud2{.is_dense = true});
  changed.put(10, 0, std::uint8_t{6});
  PointCloud2 cloud;
  EXPECT_EQ(changed.decoded(cloud), WalkStatus::bad_boolean);
  unsigned char byte;
  std::memcpy(&byte, &cloud.is_dense, sizeof byte);
  EXPECT_LE(byte, 1);
}

TEST(DecodeTest, NoMoreElementsAreMadeThanTheBytesCanHold) {
  torture::Sequences sequences;
  sequences.texts = {"a"};
  sequences.points = {{1, 2}};
  for (const std::size_t slot : {3U, 4U, 8U, 10U}) {  // the slots of eight, texts, points and headers
    Changed changed(sequences);
    changed.put(slot, 0, std::uint32_t{0x1000'0000});
    torture::Sequences value;
    EXPECT_NE(changed.decoded(value), WalkStatus::ok) << slot;
    EXPECT_LE(value.texts.capacity() + value.points.capacity() + value.headers.capacity(), 1000U) << slot;
  }
}

TEST(DecodeTest, ElementsWithoutContentsAreCreatedUpToALimit) {
  using F = PointCloud2::Field;
  const FieldMask mask(F::fields.size);
  for (const std::uint32_t length : {max_empty_elements, max_empty_elements + 1}) {
    const SampleState state{reinterpret_cast<const std::byte*>(&length), sizeof length, nullptr, &mask};
    PointCloud2 cloud;
    const WalkStatus status = decode(state, TypeTable<PointCloud2>::type, &cloud);
    EXPECT_EQ(status, length <= max_empty_elements ? WalkStatus::ok : WalkStatus::bad_length);
    EXPECT_EQ(cloud.fields.size(), length <= max_empty_elements ? length : 0U);
  }
}

}  // namespace
}  // namespace sft
