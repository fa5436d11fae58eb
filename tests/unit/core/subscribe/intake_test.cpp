// The order of samples between the two paths of a subscriber, and the losses, without ports, clocks or
// threads.
#include "core/subscribe/intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "tests/unit/core/subscribe/intake_fixture.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(IntakeTest, SamplesOfOneWriterComeByRisingSequenceWhicheverPathBringsThem) {
  over_network({1});
  in_memory({2});
  over_network({3});
  in_memory({4});
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(status().received, 4U);
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(IntakeTest, BetweenWritersTheOlderStampGoesFirst) {
  in_memory({.sequence = 1, .writer = 8, .stamp_ns = 30});
  over_network({.sequence = 1, .writer = 9, .stamp_ns = 20});
  over_network({.sequence = 2, .writer = 9, .stamp_ns = 40});
  std::vector<EndpointId> writers;
  for (Taken next = take(); next.sample; next = take()) writers.push_back(next.info.writer);
  EXPECT_THAT(writers, ElementsAre(9, 8, 9));
}

TEST_F(IntakeTest, ASampleTellsWhereItCameFrom) {
  in_memory({.sequence = 1, .stamp_ns = 5});
  over_network({.sequence = 2, .stamp_ns = 6});
  network.back()->receive_stamp_ns = 7;
  EXPECT_EQ(take().info.transport, TransportKind::shm);
  const SampleInfo second = take().info;
  EXPECT_EQ(second.transport, TransportKind::udp);
  EXPECT_EQ(second.writer, 9U);
  EXPECT_EQ(second.source_stamp.time_since_epoch().count(), 6);
  EXPECT_EQ(second.receive_stamp.time_since_epoch().count(), 7);
}

TEST_F(IntakeTest, SamplesOfDdsWritersGoByTheirStampsAndWaitForNoOthers) {
  intake->put(Inlet::vanilla, sample({.sequence = 5, .writer = 8, .stamp_ns = 30}));
  in_memory({.sequence = 1, .stamp_ns = 20});
  over_network({.sequence = 2, .stamp_ns = 40});
  std::vector<TransportKind> transports;
  for (Taken next = take(); next.sample; next = take()) transports.push_back(next.info.transport);
  EXPECT_THAT(transports, ElementsAre(TransportKind::shm, TransportKind::dds, TransportKind::udp));
}

TEST_F(IntakeTest, ADdsWriterThatRestartsUnderItsOldNameIsHeardAndItsRetainedSamplesComeOnce) {
  const auto comes = [&](std::uint64_t sequence, std::int64_t stamp_ns) {
    intake->put(Inlet::vanilla, sample({.sequence = sequence, .writer = 8, .stamp_ns = stamp_ns}));
    return static_cast<bool>(take().sample);
  };
  EXPECT_TRUE(comes(41, 1000));
  EXPECT_TRUE(comes(42, 2000));
  EXPECT_FALSE(comes(41, 1000));
  EXPECT_TRUE(comes(1, 3000));
  EXPECT_TRUE(comes(2, 4000));
  EXPECT_FALSE(comes(1, 3000));
  EXPECT_EQ(status().lost, 0U);
  EXPECT_TRUE(comes(4, 5000));
  EXPECT_EQ(status().lost, 1U);
}

TEST_F(IntakeTest, ASampleThatBothPathsBringIsTakenOnce) {
  over_network({1});
  over_network({2});
  in_memory({2});
  in_memory({3});
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3));
  EXPECT_EQ(status().received, 3U);
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().withheld, 0U);
  EXPECT_EQ(status().expired, 0U) << "what came twice was dropped for another reason";
}

TEST_F(IntakeTest, EveryDropOfASampleIsADecisionAfterWhichTheInletsAreFilledAnew) {
  in_memory({1});
  ASSERT_EQ(decide(), Decision::deliver);
  intake->take();
  in_memory({1});
  in_memory({2});
  EXPECT_EQ(decide(), Decision::dropped);
  EXPECT_TRUE(intake->is_empty(Inlet::memory));
  EXPECT_EQ(decide(), Decision::deliver);
}

/// The first sample came in shared memory. The third one has arrived, too, and names the second one as
/// diverted.
class DivertedTest : public IntakeTest {
 protected:
  DivertedTest() {
    in_memory({1});
    EXPECT_THAT(taken(), ElementsAre(1));
    now_ns = 10;
    in_memory({.sequence = 3, .diverted = 2, .diverted_ns = 5});
  }
};

TEST_F(DivertedTest, ASampleInSharedMemoryWaitsForAnEarlierOneThatWentByUdp) {
  EXPECT_EQ(decide(), Decision::ask_connected);
  EXPECT_EQ(intake->asked_about(), 9U);
  EXPECT_EQ(answer_connected(true), Decision::nothing);
  over_network({2});
  EXPECT_THAT(taken(), ElementsAre(2, 3));
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(DivertedTest, ThatASampleWasHeldBackIsToldOnce) {
  EXPECT_FALSE(intake->take_held_back());
  EXPECT_FALSE(take().sample);
  EXPECT_TRUE(intake->take_held_back());
  EXPECT_FALSE(intake->take_held_back());
}

TEST_F(DivertedTest, WhileASampleWaitsThoseOfOtherWritersThatCameByUdpGoFirst) {
  over_network({.sequence = 1, .writer = 8, .stamp_ns = 100});
  over_network({2});
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3));
}

TEST_F(DivertedTest, WhileASampleWaitsThoseOfDdsWritersGoFirst) {
  intake->put(Inlet::vanilla, sample({.sequence = 7, .writer = 8, .stamp_ns = 100}));
  EXPECT_THAT(taken(), ElementsAre(7));
  over_network({2});
  EXPECT_THAT(taken(), ElementsAre(2, 3));
}

TEST_F(DivertedTest, NobodyWaitsForAWriterThatIsNotConnectedByUdp) {
  is_connected = false;
  EXPECT_THAT(taken(), ElementsAre(3));
  EXPECT_EQ(status().lost, 1U);
  EXPECT_FALSE(intake->take_held_back());
}

TEST_F(DivertedTest, WaitsNoLongerThanTheTimeoutSinceTheDivertedSampleWasSent) {
  now_ns = 5 + timeout_ns - 1;
  EXPECT_FALSE(take().sample);
  now_ns = 5 + timeout_ns;
  EXPECT_THAT(taken(), ElementsAre(3));
  EXPECT_EQ(status().lost, 1U);
}

TEST_F(DivertedTest, NobodyWaitsWhereTheClockWasSetBack) {
  now_ns = 4;
  EXPECT_THAT(taken(), ElementsAre(3));
}

TEST_F(DivertedTest, NobodyWaitsOnceALaterSampleOfTheWriterHasComeByUdp) {
  over_network({4});
  EXPECT_THAT(taken(), ElementsAre(3, 4));
  EXPECT_EQ(status().lost, 1U);
}

TEST_F(IntakeTest, ADivertedSampleThatHasComeIsNotWaitedFor) {
  in_memory({1});
  over_network({2});
  in_memory({.sequence = 3, .diverted = 2});
  in_memory({.sequence = 5, .diverted = 2});
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3, 5));
  EXPECT_EQ(status().lost, 1U);
}

TEST_F(IntakeTest, WhatWasDivertedBeforeTheWriterWasHeardIsNotWaitedFor) {
  now_ns = 10;
  hear(9);
  in_memory({.sequence = 2, .diverted = 1, .diverted_ns = 9});
  EXPECT_THAT(taken(), ElementsAre(2));
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(IntakeTest, WhatWasDivertedSinceTheWriterWasHeardIsWaitedForHoweverOftenItIsHeard) {
  now_ns = 10;
  hear(9);
  now_ns = 100;
  hear(9);
  in_memory({.sequence = 2, .diverted = 1, .diverted_ns = 50});
  EXPECT_EQ(decide(), Decision::ask_connected);
}

TEST_F(IntakeTest, ADivertedSampleThatTheMaximumRateDoesNotAllowIsNotWaitedFor) {
  reopen({.timeout = std::chrono::nanoseconds(timeout_ns), .min_period_us = 1});
  in_memory({.sequence = 1, .stamp_ns = 10'000});
  in_memory({.sequence = 2, .stamp_ns = 10'100});
  in_memory({.sequence = 4, .stamp_ns = 13'000, .diverted = 3, .diverted_ns = 10'200});
  now_ns = 10'300;
  EXPECT_THAT(taken(), ElementsAre(1, 4)) << "nothing is saved at first";
}

// A writer that also serves other readers in shared memory does not name a sample that went by UDP to this
// subscriber alone.
TEST_F(IntakeTest, AfterASampleThatCameByUdpAGapInSharedMemoryIsWaitedForToo) {
  over_network({1});
  EXPECT_THAT(taken(), ElementsAre(1));
  in_memory({3});
  now_ns = 3 + timeout_ns - 1;
  EXPECT_THAT(taken(), IsEmpty());
  over_network({2});
  EXPECT_THAT(taken(), ElementsAre(2, 3));
  in_memory({5});
  EXPECT_THAT(taken(), ElementsAre(5)) << "the last one came in shared memory";
}

TEST_F(IntakeTest, ASampleThatFollowsIsDeliveredWithoutAQuestion) {
  in_memory({1});
  in_memory({.sequence = 2, .diverted = 1});
  EXPECT_EQ(decide(), Decision::deliver);
  intake->take();
  EXPECT_EQ(decide(), Decision::deliver);
}

TEST_F(IntakeTest, EarlierSamplesThatLieBehindOthersInSharedMemoryGoBeforeTheOneThatCameByUdp) {
  in_memory({.sequence = 1, .writer = 8, .stamp_ns = 100});
  in_memory({1});
  in_memory({2});
  over_network({3});
  ASSERT_EQ(decide(), Decision::ask_overtaken);
  EXPECT_EQ(intake->asked_about(), 9U);
  EXPECT_THAT(taken(), ElementsAre(1, 2, 3, 1));
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(IntakeTest, SharedMemoryIsNotLookedThroughIfTheWritersNextSampleIsTheFirstThere) {
  in_memory({.sequence = 4, .stamp_ns = 50});
  over_network({.sequence = 2, .stamp_ns = 20});
  EXPECT_EQ(decide(), Decision::deliver);
  EXPECT_EQ(intake->take().info.sequence, 2U);
}

TEST_F(IntakeTest, IfNothingEarlierIsFoundTheSampleThatCameByUdpIsNext) {
  over_network({3});
  ASSERT_EQ(decide(), Decision::ask_overtaken);
  EXPECT_EQ(answer_overtaken({}), Decision::deliver);
  EXPECT_EQ(intake->take().info.sequence, 3U);
}

TEST_F(IntakeTest, ALaterSampleThatIsFoundInSharedMemoryIsKeptForItsTurn) {
  in_memory({.sequence = 1, .writer = 8, .stamp_ns = 100});
  in_memory({5});
  over_network({3});
  EXPECT_THAT(taken(), ElementsAre(3, 5, 1));
  EXPECT_EQ(status().lost, 1U) << "the fourth one";
}

TEST_F(IntakeTest, TheNextSampleReportsTheGapBeforeIt) {
  over_network({5});
  over_network({8});
  EXPECT_EQ(take().info.lost_before, 0U) << "nobody knows what was sent before the first one";
  EXPECT_EQ(take().info.lost_before, 2U);
  EXPECT_EQ(status().lost, 2U);
  EXPECT_EQ(intake->accounts().losses(), 2U);
}

TEST_F(IntakeTest, EveryWriterHasItsOwnSequence) {
  over_network({.sequence = 5, .writer = 9});
  over_network({.sequence = 6, .writer = 10});
  over_network({.sequence = 7, .writer = 9});
  EXPECT_THAT(taken(), ElementsAre(5, 6, 7));
  EXPECT_EQ(status().lost, 1U);
}

TEST_F(IntakeTest, RetainedSamplesThatWereOwedAndDidNotComeAreLost) {
  hear(9, {}, 3);
  over_network({10});
  EXPECT_EQ(take().info.lost_before, 3U);
}

TEST_F(IntakeTest, WhereSamplesExpireNobodyKnowsHowManyWereOwed) {
  hear(9, std::chrono::minutes(1), 3);
  over_network({10});
  EXPECT_EQ(take().info.lost_before, 0U);
}

TEST_F(IntakeTest, AnExpiredSampleIsDroppedAndCountsAsExpiredAndNotAsLost) {
  hear(9, std::chrono::nanoseconds(100));
  now_ns = 1000;
  over_network({.sequence = 1, .stamp_ns = 899});
  over_network({.sequence = 2, .stamp_ns = 900});
  EXPECT_THAT(taken(), ElementsAre(2));
  EXPECT_EQ(status().expired, 1U);
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().writers.at(0).expired, 1U);
}

TEST_F(IntakeTest, WhatIsMissingBeforeAnExpiredSampleIsReportedByTheNextOneThatIsDelivered) {
  hear(9, std::chrono::nanoseconds(100));
  now_ns = 1000;
  over_network({.sequence = 1, .stamp_ns = 950});
  over_network({.sequence = 4, .stamp_ns = 1});
  over_network({.sequence = 5, .stamp_ns = 960});
  EXPECT_EQ(take().info.lost_before, 0U);
  EXPECT_EQ(take().info.lost_before, 2U);
}

TEST_F(IntakeTest, TheMaximumRateWithholdsSamplesInSharedMemoryAndNoneThatItsWriterHasSentByUdp) {
  reopen({.timeout = std::chrono::nanoseconds(timeout_ns), .min_period_us = 1});
  for (std::uint64_t i = 1; i <= 10; ++i)
    in_memory({.sequence = i, .stamp_ns = 100'000 + static_cast<std::int64_t>(i)});
  EXPECT_THAT(taken(), ElementsAre(1));
  EXPECT_EQ(status().withheld, 9U);
  for (std::uint64_t i = 11; i <= 20; ++i)
    over_network({.sequence = i, .stamp_ns = 100'000 + static_cast<std::int64_t>(i)});
  EXPECT_EQ(taken().size(), 10U);
  EXPECT_EQ(status().withheld, 9U);
  EXPECT_EQ(status().lost, 0U);
  EXPECT_EQ(status().expired, 0U);
}

TEST_F(IntakeTest, AMaximumRateThatIsAskedForLaterHoldsForWritersThatAreHeardAndForNewOnes) {
  in_memory({.sequence = 1, .stamp_ns = 1000});
  EXPECT_EQ(taken().size(), 1U);
  intake->accounts().ask(1'000'000);
  for (const EndpointId writer : {9U, 10U}) {
    for (std::uint64_t i = 2; i <= 10; ++i)
      in_memory({.sequence = i, .writer = writer, .stamp_ns = 1000 + static_cast<std::int64_t>(i)});
  }
  EXPECT_LE(taken().size(), 4U);
  EXPECT_EQ(status().max_rate_hz, 1.0);
}

TEST_F(IntakeTest, SequencesThatBeginAnewByTheWordOfTheTransportAreBelieved) {
  over_network({1000});
  over_network({.sequence = 1, .numbering = 1});
  over_network({.sequence = 2, .numbering = 1});
  EXPECT_THAT(taken(), ElementsAre(1000, 1, 2));
  EXPECT_EQ(status().lost, 0U);
}

TEST_F(IntakeTest, TheSecondSampleInARowThatIsFarBehindTellsThatAForgedNumberWasAhead) {
  constexpr std::uint64_t forged = std::uint64_t{1} << 40;
  over_network({1});
  over_network({forged});
  over_network({2});
  over_network({3});
  EXPECT_THAT(taken(), ElementsAre(1, forged, 3));
}

TEST_F(IntakeTest, TheLatestSampleReportsItsLossesAndThoseOfSamplesThatWerePassedOver) {
  for (const std::uint64_t sequence : {1U, 3U, 6U}) over_network({sequence});
  const Taken newest = latest();
  EXPECT_EQ(newest.info.sequence, 6U);
  EXPECT_EQ(newest.info.lost_before, 3U);
  EXPECT_EQ(status().received, 3U);
}

TEST_F(IntakeTest, TheLatestOfSeveralWritersIsTheOneThatWasPublishedLast) {
  over_network({.sequence = 1, .writer = 9, .stamp_ns = 100});
  over_network({.sequence = 1, .writer = 10, .stamp_ns = 300});
  over_network({.sequence = 2, .writer = 9, .stamp_ns = 200});
  EXPECT_EQ(latest().info.writer, 10U);
}

TEST_F(IntakeTest, TheLatestOfOneWriterHasTheHighestSequenceEvenIfTheClockWasSetBack) {
  over_network({.sequence = 1, .stamp_ns = 300});
  over_network({.sequence = 2, .stamp_ns = 100});
  EXPECT_EQ(latest().info.sequence, 2U);
}

TEST_F(IntakeTest, LossesOfAWriterThatWasPassedOverAreReportedByItsNextSample) {
  over_network({.sequence = 1, .writer = 9, .stamp_ns = 100});
  over_network({.sequence = 5, .writer = 9, .stamp_ns = 200});
  over_network({.sequence = 1, .writer = 10, .stamp_ns = 300});
  EXPECT_EQ(latest().info.lost_before, 0U);
  over_network({.sequence = 7, .writer = 9, .stamp_ns = 400});
  EXPECT_EQ(take().info.lost_before, 4U);
}

TEST_F(IntakeTest, ASampleThatIsCopiedCountsAsReceivedOnceTheCopyIsDelivered) {
  reopen({});
  intake->copy(true, false);
  in_memory({1});
  const Taken next = take();
  EXPECT_EQ(status().received, 0U);
  intake->copied(next.info, true);
  EXPECT_EQ(status().received, 1U);
  over_network({2});
  take();
  EXPECT_EQ(status().received, 2U) << "what comes by UDP is not copied";
}

TEST_F(IntakeTest, ASampleThatCouldNotBeCopiedIsLostAndTheNextOneReportsItWithTheGapBeforeIt) {
  reopen({});
  intake->copy(true, false);
  in_memory({1});
  in_memory({3});
  in_memory({4});
  intake->copied(take().info, true);
  intake->copied(take().info, false);
  EXPECT_EQ(take().info.lost_before, 2U);
  EXPECT_EQ(status().lost, 2U);
  EXPECT_EQ(intake->accounts().losses(), 2U);
}

TEST_F(IntakeTest, CopiedSamplesThatArePassedOverCountAsReceived) {
  reopen({});
  intake->copy(true, false);
  for (const std::uint64_t sequence : {1U, 2U, 3U}) in_memory({sequence});
  const Taken newest = latest();
  EXPECT_EQ(status().received, 2U);
  intake->copied(newest.info, true);
  EXPECT_EQ(status().received, 3U);
}

TEST_F(IntakeTest, CountsOfWritersThatDepartedRemainInTheSumsAfterTheWritersWereForgotten) {
  for (EndpointId writer = 100; writer < 200; ++writer) {
    over_network({.sequence = 1, .writer = writer});
    over_network({.sequence = 3, .writer = writer});
  }
  EXPECT_EQ(taken().size(), 200U);
  for (const EndpointId writer : {100, 101, 101}) ++intake->accounts().of(writer).restarts;
  hear(9);
  EXPECT_EQ(status().received, 200U);
  EXPECT_EQ(status().lost, 100U);
  EXPECT_EQ(status().restarts, 3U);
  EXPECT_EQ(intake->accounts().find(100), nullptr);
}

TEST_F(IntakeTest, TheCountsOfAWriterThatIsHeardAgainAfterItWasGoneGoOn) {
  hear(9);
  for (const std::uint64_t sequence : {1, 4}) over_network({.sequence = sequence, .writer = 9});
  EXPECT_EQ(taken().size(), 2U);
  intake->accounts().keeps_promises(9, 5, false);
  ++intake->accounts().of(9).restarts;
  hear(8);
  over_network({.sequence = 5, .writer = 9});
  EXPECT_EQ(taken().size(), 1U) << "its last samples can still be taken";
  hear(9);
  over_network({.sequence = 7, .writer = 9});
  EXPECT_EQ(taken().size(), 1U);
  const SubscriberStatus again = status();
  EXPECT_EQ(again.writers.at(0).received, 4U);
  EXPECT_EQ(again.writers.at(0).lost, 3U);
  EXPECT_EQ(again.writers.at(0).deadlines_missed, 5U);
  EXPECT_EQ(again.writers.at(0).restarts, 1U);
  EXPECT_EQ(again.received, 4U);
  EXPECT_EQ(again.lost, 3U);
}

TEST_F(IntakeTest, ThatAWriterKeepsItsPromisesIsNewsOnlyIfSomethingDiffers) {
  hear(9);
  EXPECT_FALSE(intake->accounts().keeps_promises(9, 0, true));
  EXPECT_TRUE(intake->accounts().keeps_promises(9, 2, true));
  EXPECT_FALSE(intake->accounts().keeps_promises(9, 0, true));
  EXPECT_TRUE(intake->accounts().keeps_promises(9, 0, false));
  EXPECT_TRUE(intake->accounts().keeps_promises(9, 1, false));
  const SubscriberStatus::Writer writer = status().writers.at(0);
  EXPECT_EQ(writer.deadlines_missed, 3U);
  EXPECT_FALSE(writer.alive);
  EXPECT_EQ(writer.reason, "no sign of life within its lease");
}

/// Each writer sends each sample by a random path. In shared memory a sample arrives at once. By UDP samples
/// arrive later, in the order of their writer, or are lost.
class RandomPathsTest : public IntakeTest {
 protected:
  struct Writer {
    std::uint64_t sent = 0;
    std::uint64_t diverted = 0;
    std::int64_t diverted_ns = 0;
    std::deque<SampleHandle> under_way;
    std::vector<std::uint64_t> taken;
  };

  void one_sends() {
    const EndpointId id = random() % writers.size();
    Writer& writer = writers[id];
    Sent sent{.sequence = ++writer.sent,
              .writer = id + 1,
              .stamp_ns = ++now_ns,
              .diverted = writer.diverted,
              .diverted_ns = writer.diverted_ns};
    if (random() % 3 != 0) {
      if (!is_lost()) in_memory(sent);
      return;
    } else {
      writer.diverted = sent.sequence;
      writer.diverted_ns = sent.stamp_ns;
    }
    if (!is_lost()) writer.under_way.push_back(sample(sent));
  }
  void one_arrives_by_network() {
    std::deque<SampleHandle>& under_way = writers[random() % writers.size()].under_way;
    if (under_way.empty()) return;
    network.push_back(std::move(under_way.front()));
    under_way.pop_front();
  }
  void some_are_taken() {
    for (std::uint64_t i = random() % 4; i > 0; --i) note(take());
  }
  void note(const Taken& next) {
    if (next.sample) writers[next.info.writer - 1].taken.push_back(next.info.sequence);
  }
  void run(int steps) {
    for (int step = 0; step < steps; ++step) {
      one_sends();
      one_arrives_by_network();
      one_arrives_by_network();
      some_are_taken();
    }
    for (Writer& writer : writers) std::ranges::move(writer.under_way, std::back_inserter(network));
    now_ns += lossy ? timeout_ns : 0;
    for (Taken next = take(); next.sample; next = take()) note(next);
  }
  bool is_lost() { return lossy && random() % 5 == 0; }

  bool lossy = false;
  std::vector<Writer> writers = std::vector<Writer>(3);
};

TEST_F(RandomPathsTest, EverySampleIsDeliveredOnceAndInOrderIfNoneGetsLost) {
  constexpr int steps = 300;  // these steps end within the time that the intake waits
  for (std::uint64_t round = sft::test::test_rounds(200); round > 0 && !HasFailure(); --round) {
    reopen(usual);
    now_ns = 0;
    writers.assign(3, {});
    run(steps);
    for (const Writer& writer : writers) {
      ASSERT_EQ(writer.taken.size(), writer.sent);
      EXPECT_TRUE(std::ranges::is_sorted(writer.taken));
    }
    EXPECT_EQ(status().lost, 0U);
  }
}

TEST_F(RandomPathsTest, SamplesThatGetLostAreCountedAndNeverComeLaterOrTwice) {
  lossy = true;
  for (std::uint64_t round = sft::test::test_rounds(200); round > 0 && !HasFailure(); --round) {
    reopen(usual);
    writers.assign(3, {});
    run(300);
    std::uint64_t missing = 0;
    for (const Writer& writer : writers) {
      if (writer.taken.empty()) continue;
      const auto unordered = std::ranges::adjacent_find(writer.taken, std::greater_equal<>());
      EXPECT_EQ(unordered, writer.taken.end());
      missing += writer.taken.back() - writer.taken.front() + 1 - writer.taken.size();
    }
    EXPECT_EQ(status().lost, missing);
  }
}

}  // namespace
}  // namespace sft::core
