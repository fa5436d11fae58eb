// The validating walk over hostile bytes names each error, and reads nothing outside of the body.
#include "sft/detail/walk.h"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/BatteryState.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/detail/decode.h"
#include "tests/support/encoded.h"
#include "tests/support/test_seed.h"

namespace sft {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using test::Encoded;

PointCloud2 small_cloud() {
  PointCloud2 c;
  c.header.frame_id = "f";
  c.fields.resize(2);
  c.fields[0].name = "x";
  c.data = {1, 2, 3};
  return c;
}

class WalkTest : public ::testing::Test {
 protected:
  WalkStatus walk() { return build_index(encoded.state(), TypeTable<PointCloud2>::type, slots); }
  void put_u32(std::uint32_t offset, std::uint32_t value) { std::memcpy(encoded.body() + offset, &value, 4); }

  Encoded encoded{small_cloud()};
  std::vector<std::uint32_t> slots = std::vector<std::uint32_t>(encoded.slots());
  const std::uint32_t* good = encoded.state().index;
};

TEST_F(WalkTest, FindsTheIndexThatTheEncoderWrote) {
  EXPECT_EQ(walk(), WalkStatus::ok);
  EXPECT_EQ(slots, std::vector<std::uint32_t>(good, good + encoded.slots()));
}

TEST_F(WalkTest, EveryTruncationIsNoticed) {
  SampleState state = encoded.state();
  for (std::uint32_t n = 0; n < encoded.state().body_bytes; ++n) {
    state.body_bytes = n;
    EXPECT_EQ(build_index(state, TypeTable<PointCloud2>::type, slots), WalkStatus::truncated) << n;
  }
}

TEST_F(WalkTest, UpToThreeBytesOfPaddingMayFollow) {
  std::vector<std::uint64_t> memory(64);
  std::memcpy(memory.data(), encoded.body(), encoded.state().body_bytes);
  SampleState state = encoded.state();
  state.body = reinterpret_cast<std::byte*>(memory.data());
  for (std::uint32_t extra = 1; extra <= 4; ++extra) {
    state.body_bytes = encoded.state().body_bytes + extra;
    EXPECT_EQ(build_index(state, TypeTable<PointCloud2>::type, slots),
              extra <= 3 ? WalkStatus::ok : WalkStatus::trailing_bytes);
  }
}

TEST_F(WalkTest, LengthsNear4GiBAreTruncationsAndNotOverflows) {
  for (const std::uint32_t length : {0xFFFFFFFFU, 0xFFFFFFFCU, 0x80000000U}) {
    put_u32(good[9], length);  // the length of data
    EXPECT_EQ(walk(), WalkStatus::truncated);
  }
}

TEST_F(WalkTest, ABooleanIsZeroOrOne) {
  encoded.body()[good[10]] = std::byte{2};
  EXPECT_EQ(walk(), WalkStatus::bad_boolean);
}

TEST_F(WalkTest, AStringEndsAtItsFirstNulAndThatOfLengthZeroIsEmpty) {
  encoded.body()[good[2] + 4] = std::byte{0};
  EXPECT_EQ(walk(), WalkStatus::bad_string);
  encoded.body()[good[2] + 5] = std::byte{'g'};
  EXPECT_EQ(walk(), WalkStatus::bad_string);
}

TEST_F(WalkTest, RandomlyChangedBytesAreRefusedOrDecodedButNeverReadOutside) {
  SCOPED_TRACE("to repeat: SFT_TEST_SEED=" + std::to_string(test::test_seed()));
  test::Random random(test::test_seed());
  const std::vector<std::byte> original = encoded.bytes();
  for (int round = 0; round < 50'000; ++round) {
    // A copy of exactly the body's size, so that the address sanitizer notices reads beyond the body.
    std::vector<std::byte> bytes = original;
    for (int i = 0; i < 3; ++i) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    bytes.resize(bytes.size() - random() % 4);
    SampleState state = encoded.state();
    state.body = bytes.data();
    state.body_bytes = static_cast<std::uint32_t>(bytes.size());
    if (build_index(state, TypeTable<PointCloud2>::type, slots) != WalkStatus::ok) continue;
    PointCloud2 value;
    ASSERT_EQ(decode(state, TypeTable<PointCloud2>::type, &value), WalkStatus::ok);
  }
}

TEST_F(WalkTest, AHugeCountOfElementsWithoutBytesCostsNothing) {
  const Encoded sizes(small_cloud(), Mask<PointCloud2>(PointCloud2::Field::fields.size));
  SampleState state = sizes.state();
  const std::uint32_t huge = 0xFFFFFFFF;
  alignas(8) std::byte body[4];
  std::memcpy(body, &huge, 4);
  state.body = body;
  EXPECT_EQ(build_index(state, TypeTable<PointCloud2>::type, slots), WalkStatus::ok);
  PointCloud2 value;
  EXPECT_EQ(decode(state, TypeTable<PointCloud2>::type, &value), WalkStatus::bad_length);
}

}  // namespace
}  // namespace sft
