// The check of a chunk that another process wrote: only a valid sample of the type is accepted.
#include "shm_transport/host/sample_check.h"

#include <gtest/gtest.h>

#include <new>
#include <vector>

#include "core/seam/gate_table.h"
#include "tests/support/shm_frame.h"

namespace sft::test {
namespace {

using namespace detail;

class SampleCheck : public ::testing::Test {
 protected:
  static constexpr core::EndpointId writer = 99;
  static constexpr std::uint32_t data = 40;

  SampleCheck() : memory_(frame_bytes(data) / 8 + 1) {
    sample_.data = reinterpret_cast<std::byte*>(memory_.data());
    new (sample_.data) SampleHeader{};
    write_frame(sample_, writer, 5, data);
  }
  bool accepts(std::size_t size = frame_bytes(data)) {
    return shm::check_sample(sample_.data, size, frame_type(), writer).has_value();
  }

  std::vector<std::uint64_t> memory_;
  core::SampleBuffer sample_;
};

TEST_F(SampleCheck, AcceptsAFrameAndReturnsItsExactSizeAndItsWriter) {
  const auto checked = shm::check_sample(sample_.data, 4096, frame_type(), writer);
  ASSERT_TRUE(checked);
  EXPECT_EQ(checked->bytes, frame_bytes(data));
  EXPECT_EQ(checked->origin.writer, writer);
  EXPECT_EQ(checked->origin.sequence, 5U);
}

TEST_F(SampleCheck, RefusesAChunkThatIsNoSample) {
  sample_.header().magic ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnotherType) {
  sample_.header().type_hash ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnotherWriter) {
  sample_.header().writer ^= 1;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesABodyBeyondTheChunk) {
  EXPECT_FALSE(accepts(frame_bytes(data) - 1));
  sample_.header().body_bytes = 0xFFFF'FFFF;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnIndexOfAnotherSize) {
  sample_.header().index_slots = 4;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesABodyAtAnotherOffset) {
  sample_.header().body_offset -= 8;
  EXPECT_FALSE(accepts());
}

TEST_F(SampleCheck, RefusesAnOffsetBehindTheBody) {
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    write_frame(sample_, writer, 5, data);
    ASSERT_TRUE(accepts());
    sample_.index()[slot] = data_offset + data;
    EXPECT_FALSE(accepts()) << slot;
    sample_.index()[slot] = data_offset + data - 1;
    EXPECT_TRUE(accepts()) << slot;
  }
}

TEST_F(SampleCheck, AcceptsASampleWithoutFieldsWhichHasNoBody) {
  for (std::uint32_t slot = 0; slot < 3; ++slot) sample_.index()[slot] = no_offset;
  sample_.header().body_bytes = 0;
  EXPECT_TRUE(accepts(frame_layout.body_offset));
  EXPECT_FALSE(accepts(frame_layout.body_offset - 1));
}

TEST_F(SampleCheck, ATableOfGatesIsPartOfTheSampleOnlyIfItLiesWithinTheChunk) {
  constexpr std::size_t bytes = frame_bytes(data);
  const auto checked_bytes = [&](std::size_t gates, std::size_t chunk_bytes) {
    sample_.header().gates = static_cast<std::uint16_t>(gates);
    const auto checked = shm::check_sample(sample_.data, chunk_bytes, frame_type(), writer);
    return checked ? checked->bytes : 0;
  };
  for (const std::size_t gates : {std::size_t{1}, std::size_t{2}, core::gates_in_table_max}) {
    const std::size_t whole = core::bytes_with_gate_table(bytes, gates);
    EXPECT_EQ(checked_bytes(gates, whole), whole) << gates;
    EXPECT_EQ(checked_bytes(gates, whole - 1), bytes) << gates;
    EXPECT_EQ(checked_bytes(gates, bytes), bytes) << gates;
  }
  for (const std::size_t gates : {core::gates_in_table_max + 1, std::size_t{65535}})
    EXPECT_EQ(checked_bytes(gates, std::size_t{1} << 24), bytes) << gates << " are more than there can be";
}

TEST_F(SampleCheck, RefusesAChunkWithoutRoomForTheHeader) {
  for (const std::size_t size : {std::size_t{0}, sizeof(SampleHeader) - 1, sizeof(SampleHeader)}) {
    EXPECT_FALSE(accepts(size)) << size;
  }
}

}  // namespace
}  // namespace sft::test
