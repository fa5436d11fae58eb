// The parts of a segment that have memory from the beginning. Only these parts are cleared.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "shm_transport/sftd/page_clearer.h"
#include "shm_transport/sftd/segment_file.h"
#include "tests/support/cleared_pages.h"
#include "tests/support/eventually.h"

namespace sft::shm {
namespace {

using Parts = std::vector<std::pair<std::size_t, std::size_t>>;

Parts at_once(std::size_t bytes, std::vector<FilePart> on_demand) {
  Parts parts;
  for (const FilePart& part :
       SegmentFile{.file = {}, .bytes = bytes, .on_demand = std::move(on_demand)}.at_once())
    parts.emplace_back(part.offset, part.bytes);
  return parts;
}

TEST(SegmentPartsTest, AreAllThatIsNotOnDemand) {
  EXPECT_EQ(at_once(100, {}), (Parts{{0, 100}}));
  EXPECT_EQ(at_once(100, {{30, 20}}), (Parts{{0, 30}, {50, 50}}));
  EXPECT_EQ(at_once(100, {{0, 10}, {10, 20}, {90, 10}}), (Parts{{30, 60}}));
  EXPECT_EQ(at_once(100, {{0, 100}}), Parts{});
}

TEST(SegmentPartsTest, OnDemandTakeNoMemoryAndAreNotCleared) {
  const std::size_t page = test::page_bytes();
  SegmentFile segment{.file = core::FileDescriptor(memfd_create("segment", MFD_CLOEXEC)),
                      .bytes = 64 * page,
                      .on_demand = {{8 * page, 16 * page}, {32 * page, 16 * page}}};
  const core::FileDescriptor file(dup(segment.file.get()));
  ASSERT_EQ(ftruncate(file.get(), static_cast<off_t>(segment.bytes)), 0);
  ASSERT_TRUE(set_aside(segment, "segment"));
  const auto taken = [&] {
    struct stat status {};
    EXPECT_EQ(fstat(file.get(), &status), 0);
    // The unit of st_blocks is 512 bytes, see stat(2).
    return static_cast<std::size_t>(status.st_blocks) * 512;
  };
  EXPECT_EQ(taken(), 32 * page);
  void* const memory = mmap(nullptr, segment.bytes, PROT_READ, MAP_SHARED, file.get(), 0);
  const std::span all(static_cast<const std::byte*>(memory), segment.bytes);
  {
    PageClearer clearer;
    std::vector<SegmentFile> segments;
    segments.push_back(std::move(segment));
    ASSERT_TRUE(clearer.start(std::move(segments)));
    EXPECT_TRUE(test::eventually([&] { return test::cleared_bytes(all) == 32 * page; }));
  }
  EXPECT_EQ(taken(), 32 * page);
  munmap(memory, all.size());
}

}  // namespace
}  // namespace sft::shm
