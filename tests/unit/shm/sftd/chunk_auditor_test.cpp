// The chunks that sftd considers lost. Ports and pools are in the memory of this process.
#include "shm_transport/sftd/chunk_auditor.h"

#include <gtest/gtest.h>

#include <iceoryx_posh/internal/mepoo/chunk_management.hpp>
#include <iceoryx_posh/mepoo/mepoo_config.hpp>
#include <iceoryx_posh/roudi/port_pool.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "shm_transport/host/chunk_hand.h"

namespace sft::test {
namespace {

using iox::mepoo::ChunkManagement;
using iox::mepoo::SharedChunk;
using iox::mepoo::ShmSafeUnmanagedChunk;

using Audit = shm::ChunkAuditor::Audit;
using Finding = shm::ChunkAuditor::Finding;
constexpr Audit busy{Finding::busy};
constexpr Audit damaged{Finding::damaged};
constexpr Audit freed(std::size_t chunks) { return {Finding::audited, chunks}; }

constexpr std::uint32_t chunk_bytes = 128;
constexpr std::uint32_t chunks = 16;

class ChunkAuditorTest : public ::testing::Test {
 protected:
  ChunkAuditorTest() {
    pools_config_.addMemPool({chunk_bytes, chunks});
    management_.resize(iox::mepoo::MemoryManager::requiredManagementMemorySize(pools_config_) / 8 + 8);
    samples_.resize(iox::mepoo::MemoryManager::requiredChunkMemorySize(pools_config_) / 8 + 8);
    iox::posix::Allocator management(management_.data(), management_.size() * 8);
    iox::posix::Allocator samples(samples_.data(), samples_.size() * 8);
    memory_.configureMemoryManager(pools_config_, management, samples);
    auditor_.emplace(pool_, memory_);
    port_ = pool_.addPublisherPort(service_, &memory_, "sft_node", {}).value();
    auditor_->note_ports();
  }

  /// Takes a chunk as a writer does.
  iox::mepoo::ChunkHeader* allocate() {
    return iox::popo::PublisherPortUser(port_).tryAllocateChunk(chunk_bytes, 8, 0, 1).value();
  }
  /// Takes a chunk as a writer does that is killed before the chunk is recorded.
  ChunkManagement* take_and_forget() {
    auto chunk = memory_.getChunk(iox::mepoo::ChunkSettings::create(chunk_bytes, 8).value()).value();
    return chunk.release();
  }
  void end_writer() {
    iox::popo::PublisherPortRouDi(port_).releaseAllChunks();
    pool_.removePublisherPort(port_);
  }
  std::uint32_t in_use() const { return memory_.getMemPoolInfo(0).m_usedChunks; }
  /// Returns true if all chunks of the pool can be taken, each of them once.
  bool is_whole() {
    std::vector<SharedChunk> all;
    for (std::uint32_t i = 0; i < chunks; ++i) {
      auto chunk = memory_.getChunk(iox::mepoo::ChunkSettings::create(chunk_bytes, 8).value());
      if (chunk.has_error()) return false;
      all.push_back(std::move(chunk.value()));
    }
    return in_use() == chunks;
  }

  const iox::capro::ServiceDescription service_{"sft", "w", "1"};
  iox::mepoo::MePooConfig pools_config_;
  std::vector<std::uint64_t> management_, samples_;
  iox::mepoo::MemoryManager memory_;
  const std::unique_ptr<iox::roudi::PortPoolData> ports_ = std::make_unique<iox::roudi::PortPoolData>();
  iox::roudi::PortPool pool_{*ports_};
  std::optional<shm::ChunkAuditor> auditor_;
  iox::popo::PublisherPortData* port_ = nullptr;
};

TEST_F(ChunkAuditorTest, LeavesTheChunksOfAWriterAlone) {
  allocate();
  EXPECT_EQ(auditor_->audit(), freed(0));
  EXPECT_EQ(in_use(), 1U);
  end_writer();
  EXPECT_EQ(auditor_->audit(), freed(0));
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, FreesAChunkThatAProgramTookAndDidNotNote) {
  allocate();
  take_and_forget();
  EXPECT_EQ(auditor_->audit(), freed(1));
  EXPECT_EQ(in_use(), 1U);
  end_writer();
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, FreesAChunkWithTooManyCountedReferencesOnceItsWriterIsGone) {
  iox::popo::PublisherPortUser(port_).sendChunk(allocate());
  ShmSafeUnmanagedChunk(port_->m_chunkSenderData.m_lastChunkUnmanaged.cloneToSharedChunk());
  EXPECT_EQ(auditor_->audit(), freed(0));
  end_writer();
  EXPECT_EQ(in_use(), 1U);
  EXPECT_EQ(auditor_->audit(), freed(1));
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, WaitsForTheReadersOfAWriterThatIsGone) {
  auto* reader = pool_.addSubscriberPort(service_, "sft_other", {}, iox::mepoo::MemoryInfo{}).value();
  iox::popo::PublisherPortUser(port_).sendChunk(allocate());
  ShmSafeUnmanagedChunk(port_->m_chunkSenderData.m_lastChunkUnmanaged.cloneToSharedChunk());
  end_writer();
  EXPECT_EQ(auditor_->audit(), freed(0));
  EXPECT_EQ(in_use(), 1U);
  pool_.removeSubscriberPort(reader);
  EXPECT_EQ(auditor_->audit(), freed(1));
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, FreesNothingWhileAProgramHasAChunkInHand) {
  take_and_forget();
  {
    const shm::ChunkInHand hand(*port_);
    EXPECT_EQ(auditor_->audit(), busy);
    EXPECT_EQ(in_use(), 1U);
  }
  EXPECT_EQ(auditor_->audit(), freed(1));
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, FreesAChunkWithoutAHeaderAndAHeaderWithoutAChunk) {
  ChunkManagement* const without_header = take_and_forget();
  without_header->m_referenceCounter = 0;
  without_header->m_chunkManagementPool->freeChunk(without_header);
  EXPECT_EQ(auditor_->audit(), freed(1));
  ChunkManagement* const without_chunk = take_and_forget();
  without_chunk->m_referenceCounter = 0;
  without_chunk->m_mempool->freeChunk(without_chunk->m_chunkHeader.get());
  EXPECT_EQ(auditor_->audit(), freed(0));
  EXPECT_TRUE(is_whole());
}

TEST_F(ChunkAuditorTest, CorrectsTheCountOfTakenChunks) {
  for (const int error : {1, -1}) {
    shm::pools_of(memory_)[0].correct_count(error);
    EXPECT_NE(in_use(), 0U);
    EXPECT_EQ(auditor_->audit(), freed(0));
    EXPECT_EQ(in_use(), 0U);
  }
}

TEST_F(ChunkAuditorTest, LeavesMemoryAloneIfTheListOfFreeChunksWasOverwritten) {
  allocate();
  // The list of free chunks is at the beginning of the management memory.
  auto* const next = reinterpret_cast<std::uint32_t*>(management_.data());
  ASSERT_EQ(next[3], 4U);
  for (const std::uint32_t nonsense : {2U, 3U, chunks + 1, 0xffffffffU}) {
    next[3] = nonsense;
    EXPECT_EQ(auditor_->audit(), damaged) << nonsense;
  }
}

}  // namespace
}  // namespace sft::test
