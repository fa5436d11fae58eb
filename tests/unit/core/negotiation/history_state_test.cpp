// Tests which retained samples have to be sent to a reader, and when these samples have to be sent again.
#include "core/negotiation/history_state.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

class HistoryStateTest : public ::testing::Test {
 protected:
  HistoryStateTest() {
    writer.id = 100;
    writer.qos = {.durability = Durability::transient_local, .history_depth = 8};
    reader.id = 200;
    reader.qos = {.durability = Durability::transient_local, .history_depth = 3};
  }
  bool is_given_all() {
    reader.request.begun = {writer.id};
    return history_state.given(writer.id, reader);
  }

  Endpoint writer, reader;
  HistoryState history_state;
};

TEST_F(HistoryStateTest, AReaderIsOwedWhatBothSidesKeep) {
  EXPECT_EQ(history_state.owed(writer, reader), 3U);
  reader.qos.durability = Durability::volatile_;
  EXPECT_EQ(history_state.owed(writer, reader), 0U);
}

TEST_F(HistoryStateTest, AReaderIsOwedNothingMoreOnceAllHasLeftAndItHasBegunToCome) {
  EXPECT_FALSE(history_state.given(writer.id, reader)) << "the reader has not said so";
  EXPECT_EQ(history_state.owed(writer, reader), 3U);
  EXPECT_TRUE(is_given_all());
  EXPECT_FALSE(is_given_all()) << "that is no news";
  EXPECT_EQ(history_state.owed(writer, reader), 0U);
}

TEST_F(HistoryStateTest, AReaderThatBeginsAnewIsOwedAllAgain) {
  is_given_all();
  history_state.begins_anew(reader);
  EXPECT_EQ(history_state.owed(writer, reader), 0U) << "its request still says that the samples have come";
  reader.request.begun.clear();
  history_state.begins_anew(reader);
  EXPECT_EQ(history_state.owed(writer, reader), 3U);
}

TEST_F(HistoryStateTest, WhatHasComeCountsAsLongAsTheReaderListensToTheWriter) {
  EXPECT_TRUE(history_state.came(reader.id, writer.id));
  EXPECT_FALSE(history_state.came(reader.id, writer.id));
  reader.request.listening = {writer.id};
  history_state.disconnected(reader, writer.id);
  EXPECT_TRUE(history_state.has_come(reader.id, writer.id));
  reader.request.listening.clear();
  history_state.disconnected(reader, writer.id);
  EXPECT_FALSE(history_state.has_come(reader.id, writer.id));
}

TEST_F(HistoryStateTest, AReaderThatComesBackAfterItWasForgottenIsOwedAllAgain) {
  is_given_all();
  history_state.forget(reader.id);
  EXPECT_EQ(history_state.owed(writer, reader), 3U);
}

TEST_F(HistoryStateTest, WhatOurReaderHasGotOutlivesItsWriterAndNotTheReader) {
  history_state.came(reader.id, writer.id);
  history_state.forget(writer.id);
  EXPECT_TRUE(history_state.has_come(reader.id, writer.id));
  history_state.forget(reader.id);
  EXPECT_FALSE(history_state.has_come(reader.id, writer.id));
}

}  // namespace
}  // namespace sft::core
