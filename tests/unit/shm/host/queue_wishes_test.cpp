// A reader's id and requests are written into the name of its port, and read back from there.
#include "shm_transport/host/queue_wishes.h"

#include <gtest/gtest.h>

namespace sft::shm {
namespace {

TEST(QueueWishesTest, AreReadFromTheNameAsTheyWereWritten) {
  for (const unsigned wishes : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U}) {
    const bool late = (wishes & 1) != 0, awaited = (wishes & 2) != 0, deepest = (wishes & 4) != 0;
    const QueueWishes written{0x0123'4567'89ab'cdef, late, awaited, deepest};
    const QueueWishes read = parse_wishes("sft_node_1_0badcafe#7" + to_text(written));
    EXPECT_EQ(read.reader, written.reader);
    EXPECT_EQ(read.late, late);
    EXPECT_EQ(read.awaited, awaited);
    EXPECT_EQ(read.deepest, deepest);
  }
}

TEST(QueueWishesTest, ALimitOfBytesIsWrittenAsAPowerOfTwoThatIsNotGreater) {
  const auto read_back = [](std::uint64_t limit) {
    return parse_wishes("name" + to_text({.reader = 0xabc, .late = true, .bytes_max = limit}));
  };
  constexpr std::uint64_t mebibyte = 1 << 20;
  EXPECT_EQ(read_back(0).bytes_max, 0U) << "no limit";
  EXPECT_EQ(read_back(32 * mebibyte).bytes_max, 32 * mebibyte);
  EXPECT_EQ(read_back(64 * mebibyte - 1).bytes_max, 32 * mebibyte);
  EXPECT_EQ(read_back(1).bytes_max, 64U << 10) << "the least one";
  EXPECT_EQ(read_back(UINT64_MAX).bytes_max, std::uint64_t{1} << 35) << "the greatest one";
  EXPECT_EQ(read_back(mebibyte).reader, 0xabcU);
  EXPECT_TRUE(read_back(mebibyte).late);
}

TEST(QueueWishesTest, AnUnknownReaderWritesNothing) {
  EXPECT_EQ(to_text({}), "");
  EXPECT_EQ(parse_wishes("sft_node_1_0badcafe#7").reader, 0U);
}

TEST(QueueWishesTest, AMalformedNameHasNoRequests) {
  for (const char* name : {"", "@", "name@", "name@xyz", "name@12 ", "name!11112222333344445", "name=12 "}) {
    const QueueWishes wishes = parse_wishes(name);
    EXPECT_EQ(wishes.reader, 0U) << name;
    EXPECT_FALSE(wishes.late || wishes.awaited || wishes.deepest) << name;
  }
}

}  // namespace
}  // namespace sft::shm
