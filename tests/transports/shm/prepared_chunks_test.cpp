// These tests count the page faults of a writer that takes large chunks.
#include <sys/resource.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <vector>

#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SampleHandle;

/// Returns the number of page faults of this thread. A page fault is the first access of the thread to a
/// page.
long page_faults_of_this_thread() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}

/// Takes chunks of one writer and keeps all of them.
class ShmLargeChunks : public ShmNodeTest {
 protected:
  void SetUp() override {
    ShmNodeTest::SetUp();
    if (!IsSkipped()) writer_.emplace(node(), 1);
  }
  void TearDown() override {
    held_.clear();
    writer_.reset();
    ShmNodeTest::TearDown();
  }
  long page_faults_of_next(std::uint32_t bytes) {
    const long before = page_faults_of_this_thread();
    held_.push_back(writer_->loan(bytes));
    if (!held_.back()) throw std::runtime_error("no chunk is free");
    std::memset(data_of(*held_.back()), 1, bytes);
    return page_faults_of_this_thread() - before;
  }

  std::optional<Writer> writer_;
  std::vector<SampleHandle> held_;
};

TEST_F(ShmLargeChunks, AreMappedBeforeTheirWriterTakesThemExceptTheFirst) {
  constexpr std::uint32_t bytes = 1'000'000;
  constexpr long most_pages = 240, few_pages = 16;  // pages out of the 245 of a sample
  constexpr int ahead = 5;
  EXPECT_GE(page_faults_of_next(bytes), most_pages) << "nobody knew that large samples would come";
  node().poll();
  for (int i = 0; i < ahead; ++i) EXPECT_LE(page_faults_of_next(bytes), few_pages) << i;
  EXPECT_GE(page_faults_of_next(bytes), most_pages) << "nobody has looked since the last five";
}

TEST_F(ShmLargeChunks, AreMappedInWhicheverOrderOthersHaveGivenThemBack) {
  constexpr std::uint32_t bytes = 1'000'000;
  constexpr long few_pages = 16;  // pages out of the 245 of a sample
  Writer other(node(), 2);
  std::array<SampleHandle, 12> chunks;
  for (SampleHandle& chunk : chunks) chunk = other.loan(bytes);
  for (const std::size_t i : {3U, 0U, 5U, 1U, 4U, 2U, 9U, 6U, 11U, 7U, 10U, 8U}) chunks[i] = {};
  page_faults_of_next(bytes);
  node().poll();
  for (int i = 0; i < 5; ++i) EXPECT_LE(page_faults_of_next(bytes), few_pages) << i;
}

TEST_F(ShmLargeChunks, AreMappedAsFarAsTheLargestSampleOfTheirSizeReached) {
  constexpr std::uint32_t small = 500'000, large = 1'000'000;
  constexpr long pages_between = 122, few_pages = 16;
  page_faults_of_next(small);
  node().poll();
  EXPECT_LE(page_faults_of_next(small), few_pages);
  EXPECT_NEAR(page_faults_of_next(large), pages_between, few_pages) << "only small ones were known";
  node().poll();
  EXPECT_LE(page_faults_of_next(large), few_pages) << "the rest of a chunk that was mapped in part";
  EXPECT_LE(page_faults_of_next(small), few_pages);
  node().poll();
  EXPECT_LE(page_faults_of_next(large), few_pages) << "the last sample was a small one";
}

TEST_F(ShmLargeChunks, OfTheNextSizeAreMappedBeforeThoseOfThisSizeAreUsedUp) {
  constexpr std::uint32_t bytes = 3'000'000;
  constexpr long few_pages = 32;  // pages out of the 733 of a sample
  const std::size_t chunks = ChunkCounter(node(), bytes).free();
  for (std::size_t i = 0; i < chunks; ++i) {
    node().poll();
    EXPECT_LE(page_faults_of_next(bytes), few_pages) << i;
  }
  EXPECT_FALSE(writer_->loan(bytes));
}

}  // namespace
}  // namespace sft::test
