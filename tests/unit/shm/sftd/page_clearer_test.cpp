// The thread that clears the pages of the daemon's segments.
#include "shm_transport/sftd/page_clearer.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <string>

#include "tests/support/eventually.h"

namespace sft::shm {
namespace {

/// A shared mapping of its own, none of whose pages was used.
class Memory {
 public:
  explicit Memory(std::size_t bytes)
      : bytes_(bytes),
        data_(static_cast<std::byte*>(
            mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))) {}
  ~Memory() { munmap(data_, bytes_); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;

  std::span<std::byte> all() const { return {data_, bytes_}; }
  /// How much of it this process has mapped.
  std::size_t mapped_bytes() const {
    std::ifstream mappings("/proc/self/smaps");
    bool is_this = false;
    for (std::string line; std::getline(mappings, line);) {
      if (line.find('-') < line.find(' '))
        is_this = std::stoull(line, nullptr, 16) == reinterpret_cast<std::uintptr_t>(data_);
      if (is_this && line.starts_with("Rss:")) return 1024 * std::stoull(line.substr(4));
    }
    return 0;
  }

 private:
  const std::size_t bytes_;
  std::byte* const data_;
};

constexpr std::size_t mebibyte = std::size_t{1} << 20;

TEST(PageClearerTest, ClearsAllPagesOfEachSegment) {
  const Memory first(mebibyte + 4096), second(3 * mebibyte);
  PageClearer clearer;
  ASSERT_TRUE(clearer.start({first.all(), second.all()}));
  EXPECT_TRUE(test::eventually([&] { return first.mapped_bytes() == mebibyte + 4096; }));
  EXPECT_TRUE(test::eventually([&] { return second.mapped_bytes() == 3 * mebibyte; }));
}

TEST(PageClearerTest, ChangesNothingThatAProgramHasWritten) {
  const Memory memory(4 * mebibyte);
  std::ranges::fill(memory.all().first(2 * mebibyte), std::byte{7});
  PageClearer clearer;
  ASSERT_TRUE(clearer.start({memory.all()}));
  for (std::size_t i = memory.all().size(); i-- > 2 * mebibyte;) memory.all()[i] = std::byte{7};
  EXPECT_TRUE(test::eventually([&] { return memory.mapped_bytes() == 4 * mebibyte; }));
  EXPECT_EQ(std::ranges::count(memory.all(), std::byte{7}), 4 * mebibyte);
}

TEST(PageClearerTest, StopsWhereItIs) {
  const Memory memory(1024 * mebibyte);
  auto clearer = std::make_unique<PageClearer>();
  ASSERT_TRUE(clearer->start({memory.all()}));
  EXPECT_TRUE(test::eventually([&] { return memory.mapped_bytes() > 0; }));
  clearer.reset();
  EXPECT_LT(memory.mapped_bytes(), 1024 * mebibyte);
}

// Somebody of the same account may have made the file shorter.
TEST(PageClearerTest, LeavesMemoryAloneThatIsGone) {
  const int file = memfd_create("segment", MFD_CLOEXEC);
  ASSERT_EQ(ftruncate(file, 4096), 0);
  void* const data = mmap(nullptr, mebibyte, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ASSERT_NE(data, MAP_FAILED);
  {
    PageClearer clearer;
    ASSERT_TRUE(clearer.start({{static_cast<const std::byte*>(data), mebibyte}}));
  }
  munmap(data, mebibyte);
  close(file);
}

}  // namespace
}  // namespace sft::shm
