// These tests check what ./run bench udp --trace makes of the packets that it has seen.
#include "bench/udp/ledger.h"

#include <gmock/gmock.h>

namespace sft::bench {

namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t us = 1000;

Packet data(std::int64_t at_us, bool outgoing) { return {at_us * us, 1500, outgoing, Packet::Kind::data}; }
Packet answer(std::int64_t at_us) { return {at_us * us, 60, false, Packet::Kind::answer}; }

constexpr Delivery delivery{.sent_at = 100 * us, .received_at = 200 * us, .returned_at = 170 * us};

TEST(BenchLedger, HasPhasesThatAddUpToTheWholeTime) {
  // The first packets belong to the sample before, and the last ones to the next one.
  const auto ledger = ledger_of(
      delivery, {data(90, true), data(110, true), answer(130), answer(138), data(150, true), data(210, true)},
      {data(95, false), data(115, false), data(120, false), data(180, false), data(220, false)});
  ASSERT_TRUE(ledger);
  EXPECT_THAT(ledger->phases, ElementsAre(10, 5, 35, 30, 20));
  EXPECT_EQ(ledger->total(), 100);
  EXPECT_EQ(ledger->publishing, 70);
  EXPECT_EQ(ledger->data_pause, 60);
  EXPECT_EQ(ledger->answer_pause, 8);
}

TEST(BenchLedger, OfASampleOfOnePacketHasNoTimeBetweenItsFirstAndItsLastByte) {
  const auto ledger = ledger_of(delivery, {data(110, true)}, {data(115, false)});
  ASSERT_TRUE(ledger);
  EXPECT_THAT(ledger->phases, ElementsAre(10, 5, 0, 0, 85));
  EXPECT_EQ(ledger->total(), 100);
}

TEST(BenchLedger, IsMissingWithoutPacketsAtOneEnd) {
  EXPECT_FALSE(ledger_of(delivery, {}, {data(115, false)}));
  EXPECT_FALSE(ledger_of(delivery, {data(110, true)}, {answer(150)}));
}

TEST(BenchLedger, HasTheMedianOfEachLine) {
  const Ledger medians = medians_of({{.phases = {1, 9, 3, 4, 5}, .publishing = 7},
                                     {.phases = {2, 2, 2, 2, 2}, .publishing = 8},
                                     {.phases = {3, 1, 1, 1, 9}, .publishing = 3}});
  EXPECT_THAT(medians.phases, ElementsAre(2, 2, 2, 2, 5));
  EXPECT_EQ(medians.publishing, 7);
}

TEST(BenchLedger, IsPrintedWithSharesBesideTheMedians) {
  const std::string table = table_of({.phases = {10, 5, 35, 30, 20}, .publishing = 70}, {.phases = {7}});
  EXPECT_THAT(table, HasSubstr("first byte leaves          10.0 us   10.0 %          7.0 us\n"));
  EXPECT_THAT(table, HasSubstr("sum                                           100.0 us  100.0 %\n"));
  EXPECT_THAT(table, HasSubstr("returned                   70.0 us   70.0 %"));
}

}  // namespace

}  // namespace sft::bench
