// The choice of the pool from which a writer takes a chunk. The pools are in the memory of this process.
#include "shm_transport/host/chunk_pools.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <iceoryx_posh/mepoo/mepoo_config.hpp>
#include <vector>

#include "tests/support/eventually.h"

namespace sft::shm {
namespace {

constexpr std::uint32_t small_bytes = 128, medium_bytes = 1024, large_bytes = 8192, chunks = 3;

class ChunkPoolsTest : public ::testing::Test {
 protected:
  ChunkPoolsTest() {
    for (const std::uint32_t bytes : {small_bytes, medium_bytes, large_bytes})
      config_.addMemPool({bytes, chunks});
    management_.resize(iox::mepoo::MemoryManager::requiredManagementMemorySize(config_) / 8 + 8);
    samples_.resize(iox::mepoo::MemoryManager::requiredChunkMemorySize(config_) / 8 + 8);
    iox::posix::Allocator management(management_.data(), management_.size() * 8);
    iox::posix::Allocator samples(samples_.data(), samples_.size() * 8);
    memory_.configureMemoryManager(config_, management, samples);
  }

  /// Takes a chunk as a writer with this choice of pools does.
  void take(const ChunkPools::Choice& choice) {
    auto chunk = memory_.getChunk(iox::mepoo::ChunkSettings::create(choice.payload_bytes, 8).value());
    ASSERT_FALSE(chunk.has_error());
    const auto before = memory_.getMemPoolInfo(choice.pool).m_usedChunks;
    taken_.push_back(std::move(chunk.value()));
    EXPECT_LE(before, chunks);
  }
  /// Returns the number of the pool that is chosen for that size, or -1 if none is chosen.
  int chosen(std::size_t bytes) const {
    const auto choice = pools_.choose(bytes);
    return choice ? static_cast<int>(choice->pool) : -1;
  }
  std::uint32_t used(std::uint32_t pool) const { return memory_.getMemPoolInfo(pool).m_usedChunks; }

 private:
  iox::mepoo::MePooConfig config_;
  std::vector<std::uint64_t> management_, samples_;

 protected:
  iox::mepoo::MemoryManager memory_;
  ChunkPools pools_{memory_};
  std::vector<iox::mepoo::SharedChunk> taken_;
};

TEST_F(ChunkPoolsTest, APoolIsChosenByTheSizeOfTheSample) {
  EXPECT_EQ(chosen(1), 0);
  EXPECT_EQ(chosen(small_bytes), 0);
  EXPECT_EQ(chosen(small_bytes + 1), 1);
  EXPECT_EQ(chosen(large_bytes), 2);
  EXPECT_EQ(chosen(large_bytes + 1), -1);
  EXPECT_EQ(pools_.largest_bytes(), large_bytes);
}

TEST_F(ChunkPoolsTest, AUsedUpPoolIsReplacedByTheNextLargerOneAndByNoOther) {
  for (std::uint32_t i = 0; i < chunks; ++i) take(*pools_.choose(100));
  EXPECT_EQ(used(0), chunks);
  EXPECT_EQ(chosen(100), 1);
  for (std::uint32_t i = 0; i < chunks; ++i) take(*pools_.choose(100));
  EXPECT_EQ(used(1), chunks);
  EXPECT_EQ(chosen(100), -1) << "small samples must leave the large chunks alone";
  EXPECT_EQ(chosen(large_bytes), 2);
}

// A killed process may leave chunks that count as free although no writer can take these chunks.
TEST_F(ChunkPoolsTest, APoolThatOnlySeemsToHaveFreeChunksIsNotAskedAgainAtOnce) {
  const auto first = *pools_.choose(100);
  pools_.note_empty(first);
  EXPECT_EQ(chosen(100), 1);
  pools_.note_empty(*pools_.choose(100));
  EXPECT_EQ(chosen(100), -1) << "a writer that asks pool after pool must come to an end";
}

TEST_F(ChunkPoolsTest, APoolThatOnlySeemedToHaveFreeChunksIsAskedAgainAfterASecond) {
  pools_.note_empty(*pools_.choose(100));
  EXPECT_EQ(chosen(100), 1);
  EXPECT_TRUE(test::eventually([&] { return chosen(100) == 0; })) << "by then sftd has found the lost chunks";
}

TEST_F(ChunkPoolsTest, AChunkThatComesBackCanBeHadAlthoughOthersHaveVanished) {
  const auto first = *pools_.choose(100);
  take(first);
  take(first);
  pools_.note_empty(first);
  EXPECT_EQ(chosen(100), 1) << "the third one has vanished";
  taken_.pop_back();
  EXPECT_EQ(chosen(100), 0);
}

TEST_F(ChunkPoolsTest, APoolThatOtherWritersEmptiedHasLostNoChunks) {
  const auto first = *pools_.choose(100);
  for (std::uint32_t i = 0; i < chunks; ++i) take(first);
  pools_.note_empty(first);
  taken_.pop_back();
  EXPECT_EQ(chosen(100), 0);
}

}  // namespace
}  // namespace sft::shm
