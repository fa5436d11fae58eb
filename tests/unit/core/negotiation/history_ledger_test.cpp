// These tests check which retained samples a reader is owed, and when it is owed them again.
#include "core/negotiation/history_ledger.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

class HistoryLedgerTest : public ::testing::Test {
 protected:
  HistoryLedgerTest() {
    writer.id = 100;
    writer.qos = {.durability = Durability::transient_local, .history_depth = 8};
    reader.id = 200;
    reader.qos = {.durability = Durability::transient_local, .history_depth = 3};
  }
  bool is_given_all() {
    reader.request.begun = {writer.id};
    return ledger.given(writer.id, reader);
  }

  Endpoint writer, reader;
  HistoryLedger ledger;
};

TEST_F(HistoryLedgerTest, AReaderIsOwedWhatBothSidesKeep) {
  EXPECT_EQ(ledger.owed(writer, reader), 3U);
  reader.qos.durability = Durability::volatile_;
  EXPECT_EQ(ledger.owed(writer, reader), 0U);
}

TEST_F(HistoryLedgerTest, AReaderIsOwedNothingMoreOnceAllHasLeftAndItHasBegunToCome) {
  EXPECT_FALSE(ledger.given(writer.id, reader)) << "the reader has not said so";
  EXPECT_EQ(ledger.owed(writer, reader), 3U);
  EXPECT_TRUE(is_given_all());
  EXPECT_FALSE(is_given_all()) << "that is no news";
  EXPECT_EQ(ledger.owed(writer, reader), 0U);
}

TEST_F(HistoryLedgerTest, AReaderThatBeginsAnewIsOwedAllAgain) {
  is_given_all();
  ledger.begins_anew(reader);
  EXPECT_EQ(ledger.owed(writer, reader), 0U) << "its request still says that the samples have come";
  reader.request.begun.clear();
  ledger.begins_anew(reader);
  EXPECT_EQ(ledger.owed(writer, reader), 3U);
}

TEST_F(HistoryLedgerTest, WhatHasComeCountsAsLongAsTheReaderListensToTheWriter) {
  EXPECT_TRUE(ledger.came(reader.id, writer.id));
  EXPECT_FALSE(ledger.came(reader.id, writer.id));
  reader.request.listening = {writer.id};
  ledger.disconnected(reader, writer.id);
  EXPECT_TRUE(ledger.has_come(reader.id, writer.id));
  reader.request.listening.clear();
  ledger.disconnected(reader, writer.id);
  EXPECT_FALSE(ledger.has_come(reader.id, writer.id));
}

TEST_F(HistoryLedgerTest, AReaderThatComesBackAfterItWasForgottenIsOwedAllAgain) {
  is_given_all();
  ledger.forget(reader.id);
  EXPECT_EQ(ledger.owed(writer, reader), 3U);
}

TEST_F(HistoryLedgerTest, WhatOurReaderHasGotOutlivesItsWriterAndNotTheReader) {
  ledger.came(reader.id, writer.id);
  ledger.forget(writer.id);
  EXPECT_TRUE(ledger.has_come(reader.id, writer.id));
  ledger.forget(reader.id);
  EXPECT_FALSE(ledger.has_come(reader.id, writer.id));
}

}  // namespace
}  // namespace sft::core
