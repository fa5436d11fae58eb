// The memory that is mapped before its use. The pools are in memory of this process that was never used.
#include "shm_transport/host/prepared_chunks.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iceoryx_posh/mepoo/mepoo_config.hpp>
#include <span>
#include <vector>

#include "tests/support/cleared_pages.h"

namespace sft::shm {
namespace {

class PreparedChunksTest : public ::testing::Test {
 protected:
  static constexpr std::size_t sample_bytes = 75 * 4096;
  const std::size_t page = test::page_bytes();

  PreparedChunksTest() {
    iox::mepoo::MePooConfig config;
    config.addMemPool({512 * 1024, 12});
    management_.resize(iox::mepoo::MemoryManager::requiredManagementMemorySize(config) / 8 + 8);
    bytes_ = iox::mepoo::MemoryManager::requiredChunkMemorySize(config) + page;
    samples_ = static_cast<std::byte*>(
        ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    ::madvise(samples_, bytes_, MADV_NOHUGEPAGE);
    iox::posix::Allocator management(management_.data(), management_.size() * 8);
    iox::posix::Allocator samples(samples_, bytes_);
    memory_.configureMemoryManager(config, management, samples);
  }
  ~PreparedChunksTest() override { ::munmap(samples_, bytes_); }

  std::span<const std::byte> samples() const { return {samples_, bytes_}; }
  std::span<const std::byte> management() const { return std::as_bytes(std::span(management_)); }
  /// Returns the number of mapped pages of the samples' memory.
  std::size_t mapped() const {
    std::vector<unsigned char> pages((bytes_ + page - 1) / page);
    EXPECT_EQ(::mincore(samples_, bytes_, pages.data()), 0);
    return static_cast<std::size_t>(
        std::ranges::count_if(pages, [](unsigned char p) { return (p & 1) != 0; }));
  }
  /// Notes a sample and prepares chunks. The arguments are the segments in which memory may be prepared.
  /// Returns the number of pages that are mapped then.
  std::size_t mapped_within(std::span<const std::byte> samples, std::span<const std::byte> management) {
    PreparedChunks prepared(memory_, samples, management);
    prepared.note(0, sample_bytes);
    prepared.prepare();
    return mapped();
  }

  iox::mepoo::MemoryManager memory_;

 private:
  std::vector<std::uint64_t> management_;
  std::byte* samples_ = nullptr;
  std::size_t bytes_ = 0;
};

TEST_F(PreparedChunksTest, MapAsMuchAsSamplesTakeOfTheNextFive) {
  const std::size_t pages = mapped_within(samples(), management());
  EXPECT_GE(pages, 5 * sample_bytes / page);
  EXPECT_LE(pages, 5 * ((sample_bytes + page - 1) / page + 1)) << "a chunk does not begin with a page";
}

TEST_F(PreparedChunksTest, LeaveAPoolAloneThatIsNotWhereItsSegmentsAre) {
  EXPECT_EQ(mapped_within(samples().first(samples().size() / 2), management()), 0U);
  EXPECT_EQ(mapped_within(samples(), management().first(8)), 0U);
  EXPECT_EQ(mapped_within({}, {}), 0U);
}

TEST_F(PreparedChunksTest, OfSmallSamplesAreNotMappedNorOfPoolsThatDoNotExist) {
  PreparedChunks prepared(memory_, samples(), management());
  prepared.note(0, PreparedChunks::large_bytes - 1);
  prepared.note(1, sample_bytes);
  prepared.note(UINT32_MAX, sample_bytes);
  prepared.prepare();
  EXPECT_EQ(mapped(), 0U);
}

}  // namespace
}  // namespace sft::shm
