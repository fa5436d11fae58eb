// A reader and its requests in the name of its port, as they are written and read back.
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
