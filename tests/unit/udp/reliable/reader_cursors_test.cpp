#include "udp_transport/reliable/reader_cursors.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

TEST(ReaderCursorsTest, KeepThePlaceOfAReaderThatStays) {
  ReaderCursors cursors;
  cursors.set({1}, 5);
  cursors.find(1)->place = 7;
  cursors.set({2, 1}, 9);
  EXPECT_EQ(cursors.find(1)->place, 7U);
  EXPECT_EQ(cursors.find(2)->place, 9U);
  cursors.set({2}, 9);
  EXPECT_EQ(cursors.find(1), nullptr);
}

TEST(ReaderCursorsTest, TellTheFirstPlaceThatOneOfTheReadersHasNotGot) {
  ReaderCursors cursors;
  EXPECT_EQ(cursors.first_not_taken(5), 5U) << "nobody reads";
  cursors.set({1, 2}, 3);
  cursors.find(1)->place = 4;
  EXPECT_EQ(cursors.first_not_taken(5), 3U);
  EXPECT_EQ(cursors.first_not_taken(2), 2U);
}

TEST(ReaderCursorsTest, GoOverToTheNextRequestBehindWhatWasPublishedBefore) {
  ReaderCursors cursors;
  cursors.set({1}, 3);
  cursors.heard(1, 2);
  cursors.end_requests(5);
  cursors.heard(1, 3);
  cursors.end_requests(6);  // the former request has to end first
  ReaderCursors::Cursor& cursor = *cursors.find(1);
  cursor.place = 4;
  cursor.turn();
  EXPECT_EQ(cursor.request, 0U);
  cursor.place = 5;
  cursor.turn();
  EXPECT_EQ(cursor.request, 2U);
  cursors.end_requests(8);
  cursor.place = 8;
  cursor.turn();
  EXPECT_EQ(cursor.request, 3U);
}

}  // namespace
}  // namespace sft::udp
