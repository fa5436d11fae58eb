// Small buffers lie in blocks that return to the system.
#include "core/seam/small_buffers.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <set>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

constexpr std::array<std::size_t, SmallBuffers::kinds> sizes{576, 1152, 2304, 4608, 9216};

class SmallBuffersTest : public sft::test::RandomTest {
 protected:
  struct Taken {
    std::byte* buffer = nullptr;
    std::size_t kind = 0;
    std::byte mark{};

    bool is_as_it_was_filled() const {
      return std::all_of(buffer, buffer + sizes[kind], [this](std::byte b) { return b == mark; });
    }
  };
  Taken take(std::size_t kind) {
    Taken taken{buffers.take(kind, sizes[kind]), kind, static_cast<std::byte>(random())};
    EXPECT_NE(taken.buffer, nullptr);
    std::memset(taken.buffer, std::to_integer<int>(taken.mark), sizes[kind]);
    return taken;
  }
  static void* block_of(const std::byte* buffer) {
    return reinterpret_cast<void*>(reinterpret_cast<std::uintptr_t>(buffer) / SmallBuffers::block_bytes *
                                   SmallBuffers::block_bytes);
  }
  static bool is_mapped(void* block) {
    std::array<unsigned char, SmallBuffers::block_bytes / 4096> pages{};
    return mincore(block, SmallBuffers::block_bytes, pages.data()) == 0;
  }

  SmallBuffers buffers;
};

TEST_F(SmallBuffersTest, AreAlignedAndKeepWhatIsWrittenWhateverIsTakenAndGivenBackMeanwhile) {
  std::vector<Taken> taken;
  for (int i = 0; i < 20'000; ++i) {
    if (taken.empty() || random() % 100 < (i < 10'000 ? 60U : 40U)) {
      taken.push_back(take(random() % sizes.size()));
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(taken.back().buffer) % SmallBuffers::alignment, 0U);
    } else {
      std::swap(taken[random() % taken.size()], taken.back());
      ASSERT_TRUE(taken.back().is_as_it_was_filled()) << i;
      buffers.give_back(taken.back().buffer);
      taken.pop_back();
    }
  }
  for (const Taken& one : taken) {
    EXPECT_TRUE(one.is_as_it_was_filled());
    buffers.give_back(one.buffer);
  }
}

TEST_F(SmallBuffersTest, EachBlockReturnsToTheSystemWithItsLastBuffer) {
  for (std::size_t kind = 0; kind < sizes.size(); ++kind) {
    std::multiset<void*> blocks;  // the block of each buffer that is in use
    std::vector<Taken> taken;
    for (int i = 0; i < 500; ++i) {
      taken.push_back(take(kind));
      blocks.insert(block_of(taken.back().buffer));
    }
    std::ranges::shuffle(taken, random);
    for (const Taken& one : taken) {
      void* const block = block_of(one.buffer);
      ASSERT_TRUE(is_mapped(block));
      buffers.give_back(one.buffer);
      blocks.erase(blocks.find(block));
      EXPECT_EQ(is_mapped(block), blocks.contains(block));
    }
  }
}

TEST_F(SmallBuffersTest, UseTheRoomOfOthersThatWereGivenBackBeforeANewBlock) {
  std::vector<Taken> taken;
  for (int i = 0; i < 500; ++i) taken.push_back(take(2));
  std::set<void*> blocks;
  for (const Taken& one : taken) blocks.insert(block_of(one.buffer));
  for (std::size_t i = 0; i < taken.size(); i += 3) buffers.give_back(taken[i].buffer);
  for (std::size_t i = 0; i < taken.size(); i += 3) {
    taken[i] = take(2);
    EXPECT_TRUE(blocks.contains(block_of(taken[i].buffer)));
  }
  for (const Taken& one : taken) buffers.give_back(one.buffer);
}

}  // namespace
}  // namespace sft::core
