// The thread that clears the pages of the daemon's segments.
#include "shm_transport/sftd/page_clearer.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <span>
#include <vector>

#include "tests/support/cleared_pages.h"
#include "tests/support/eventually.h"

namespace sft::shm {
namespace {

/// A file in memory whose pages are allocated, like those of a segment, and a mapping of the file.
class Segment {
 public:
  explicit Segment(std::size_t bytes) : bytes_(bytes), file_(memfd_create("segment", MFD_CLOEXEC)) {
    EXPECT_EQ(posix_fallocate(file_.get(), 0, static_cast<off_t>(bytes)), 0);
    data_ = static_cast<std::byte*>(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_.get(), 0));
  }
  ~Segment() { munmap(data_, bytes_); }
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  SegmentFile file() const { return {core::FileDescriptor(dup(file_.get())), bytes_}; }
  std::span<std::byte> all() const { return {data_, bytes_}; }
  int fd() const { return file_.get(); }
  std::size_t cleared_bytes() const { return test::cleared_bytes(all()); }

 private:
  const std::size_t bytes_;
  const core::FileDescriptor file_;
  std::byte* data_ = nullptr;
};

constexpr std::size_t mebibyte = std::size_t{1} << 20;

std::vector<SegmentFile> files_of(const auto&... segments) {
  std::vector<SegmentFile> files;
  (files.push_back(segments.file()), ...);
  return files;
}

TEST(PageClearerTest, ClearsAllPagesOfEachSegment) {
  const Segment first(mebibyte + test::page_bytes()), second(3 * mebibyte);
  EXPECT_EQ(first.cleared_bytes() + second.cleared_bytes(), 0U);
  PageClearer clearer;
  ASSERT_TRUE(clearer.start(files_of(first, second)));
  EXPECT_TRUE(test::eventually([&] { return first.cleared_bytes() == mebibyte + test::page_bytes(); }));
  EXPECT_TRUE(test::eventually([&] { return second.cleared_bytes() == 3 * mebibyte; }));
}

TEST(PageClearerTest, ChangesNothingThatAProgramHasWritten) {
  const Segment segment(4 * mebibyte);
  std::ranges::fill(segment.all().first(2 * mebibyte), std::byte{7});
  PageClearer clearer;
  ASSERT_TRUE(clearer.start(files_of(segment)));
  for (std::size_t i = segment.all().size(); i-- > 2 * mebibyte;) segment.all()[i] = std::byte{7};
  EXPECT_TRUE(test::eventually([&] { return segment.cleared_bytes() == 4 * mebibyte; }));
  EXPECT_EQ(std::ranges::count(segment.all(), std::byte{7}), 4 * mebibyte);
}

/// On a busy machine, all pages may be cleared before this thread runs again. Then the test tries again.
TEST(PageClearerTest, StopsWhereItIs) {
  EXPECT_TRUE(test::eventually([] {
    const Segment segment(256 * mebibyte);
    {
      PageClearer clearer;
      EXPECT_TRUE(clearer.start(files_of(segment)));
    }
    return segment.cleared_bytes() < 256 * mebibyte;
  }));
}

// Another process of the same account may have made the file shorter.
TEST(PageClearerTest, DoesNotMakeAFileLongerThatWasMadeShorter) {
  const auto page = static_cast<off_t>(test::page_bytes());
  const Segment segment(mebibyte);
  ASSERT_EQ(ftruncate(segment.fd(), page), 0);
  {
    PageClearer clearer;
    ASSERT_TRUE(clearer.start(files_of(segment)));
  }
  struct stat after {};
  ASSERT_EQ(fstat(segment.fd(), &after), 0);
  EXPECT_EQ(after.st_size, page);
  EXPECT_LE(after.st_blocks * 512, page) << "nothing is set aside behind the end";
}

}  // namespace
}  // namespace sft::shm
