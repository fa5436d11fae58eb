// These tests check which sequences, ordinals and channels a reader accepts when it has to find the right
// numbers again.
#include <gtest/gtest.h>

#include "core/seam/buffer_pool.h"
#include "udp_transport/receive/keep_last_queue.h"
#include "udp_transport/reliable/channel_monitor.h"
#include "udp_transport/reliable/ordinal_monitor.h"
#include "udp_transport/reliable/sequence_monitor.h"

namespace sft::udp {
namespace {

using namespace detail;

using namespace std::chrono_literals;

class ResyncOfSequences : public testing::Test {
 protected:
  bool accepts(std::uint64_t sequence, std::uint64_t place = 0) {
    return monitor.accepts({sequence, place, ++datagram, ++stamp_ns}, now);
  }
  SequenceMonitor monitor;
  SequenceMonitor::Time now{1h};
  std::uint64_t datagram = 0;
  std::int64_t stamp_ns = 0;
};

TEST_F(ResyncOfSequences, AcceptsAnyFirstSequenceAndStepsWithinReach) {
  EXPECT_TRUE(accepts(5'000'000));
  EXPECT_TRUE(accepts(5'000'000 + SequenceMonitor::reach));
  EXPECT_EQ(monitor.newest(), 5'000'000 + SequenceMonitor::reach);
  EXPECT_EQ(monitor.numbering(), 0U);
}

TEST_F(ResyncOfSequences, BelievesAJumpOutOfReachOnlyWhenOthersNearItGoOnForAWhile) {
  accepts(100);
  EXPECT_FALSE(accepts(10'000'001));
  EXPECT_FALSE(accepts(10'000'002));
  now += 249ms;
  EXPECT_FALSE(accepts(10'000'004));
  now += 1ms;
  EXPECT_FALSE(accepts(10'000'003)) << "a numbering goes on with a new sequence";
  EXPECT_EQ(monitor.newest(), 100U);
  EXPECT_TRUE(accepts(10'000'005));
  EXPECT_EQ(monitor.numbering(), 1U);
  EXPECT_FALSE(monitor.newest_was_wrong());
}

TEST_F(ResyncOfSequences, ComesBackFromAFirstSequenceThatWasFarTooHigh) {
  accepts(4'000'000'000);
  EXPECT_FALSE(accepts(2));
  EXPECT_FALSE(accepts(1)) << "datagrams overtake each other";
  now += 250ms;
  EXPECT_TRUE(accepts(3));
  EXPECT_EQ(monitor.newest(), 3U);
  EXPECT_TRUE(monitor.newest_was_wrong());
}

TEST_F(ResyncOfSequences, ForgetsAJumpOnceATrueSequenceComes) {
  for (const std::uint64_t true_one : {101U, 102U, 102U, 101U}) {
    accepts(100);
    EXPECT_FALSE(accepts(1'000'000'000));
    now += 250ms;
    EXPECT_TRUE(accepts(true_one)) << "also one that is late, or comes again";
    EXPECT_FALSE(accepts(1'000'000'001));
  }
}

TEST_F(ResyncOfSequences, DoesNotLetADatagramConfirmItself) {
  accepts(100);
  EXPECT_FALSE(monitor.accepts({1'000'000'000, 0, 99}, now));
  now += 250ms;
  EXPECT_FALSE(monitor.accepts({1'000'000'001, 0, 99}, now));
}

TEST_F(ResyncOfSequences, TakesNoRepetitionForAConfirmation) {
  accepts(100);
  for (int i = 0; i < 10; ++i, now += 250ms) EXPECT_FALSE(accepts(1'000'000'000));
}

TEST_F(ResyncOfSequences, BelievesAtOnceWhatAWriterCanHavePublishedWhileItWasNotHeard) {
  accepts(100);
  now += 1min;
  EXPECT_TRUE(accepts(100'000'000));
  EXPECT_EQ(monitor.numbering(), 0U) << "all of these are lost";
}

TEST_F(ResyncOfSequences, BeginsAnewWhereLateSamplesAscendAndNothingNewComes) {
  accepts(100);
  accepts(60'000);
  EXPECT_TRUE(accepts(101));
  now += 250ms;
  EXPECT_TRUE(accepts(102));
  EXPECT_EQ(monitor.numbering(), 1U);
  EXPECT_EQ(monitor.newest(), 102U);
}

TEST_F(ResyncOfSequences, BeginsAnewAlsoWhereRepairsComeBetweenTheNewSamples) {
  accepts(100);
  accepts(205);
  const std::int64_t before_it = stamp_ns - 1;
  for (const std::uint64_t n : {1U, 2U}) {
    now += 250ms;
    EXPECT_TRUE(monitor.accepts({40 + n, 0, ++datagram, before_it}, now)) << "was published before it";
    EXPECT_TRUE(accepts(100 + n));
    EXPECT_EQ(monitor.numbering(), n - 1);
  }
  EXPECT_EQ(monitor.newest(), 102U);
}

TEST_F(ResyncOfSequences, BeginsAnewWithANewSampleAndNotWithARepair) {
  accepts(100);
  accepts(205);
  accepts(110);
  now += 250ms;
  accepts(101);
  EXPECT_EQ(monitor.numbering(), 0U);
  accepts(111);
  EXPECT_EQ(monitor.newest(), 111U);
}

TEST_F(ResyncOfSequences, StaysWithTheNewestWhereASlowPathBringsOlderSamplesLate) {
  accepts(100);
  const std::int64_t before_the_newest = stamp_ns;
  stamp_ns += 100;
  accepts(129);
  now += 1s;
  for (const std::uint64_t late : {108U, 109U, 110U})
    EXPECT_TRUE(monitor.accepts({late, 0, ++datagram, before_the_newest}, now)) << late;
  EXPECT_EQ(monitor.numbering(), 0U);
}

TEST_F(ResyncOfSequences, BeginsAnewAfterManyLateSamplesInARowThatComeOverAWhile) {
  accepts(60'000);
  const std::int64_t stamp_of_each = stamp_ns - 1;  // The stamp is earlier than that of the newest sample.
  const auto comes = [&](std::uint64_t late) {
    now += 4ms;
    monitor.accepts({late, 0, ++datagram, stamp_of_each}, now);
  };
  for (std::uint64_t late = 1; late < SequenceMonitor::late_in_a_row; ++late) comes(late);
  EXPECT_EQ(monitor.numbering(), 0U);
  comes(1'000);
  EXPECT_EQ(monitor.numbering(), 1U);
}

TEST_F(ResyncOfSequences, StaysWithTheNewestWhereManyOlderSamplesThatWereHeldUpComeAllAtOnce) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) accepts(sequence);
  accepts(150);
  now += 1ms;
  for (std::uint64_t late = 11; late < 150; ++late) {
    now += 1us;
    EXPECT_TRUE(accepts(late)) << late;
  }
  EXPECT_EQ(monitor.numbering(), 0U);
  EXPECT_EQ(monitor.newest(), 150U);
}

TEST_F(ResyncOfSequences, DoesNotTakeRepairsForASignOfAWrongSequence) {
  accepts(1'000, 1'000);
  now += 1s;
  for (std::uint64_t late = 1; late < 200; ++late) accepts(late, late);
  EXPECT_EQ(monitor.numbering(), 0U);
}

TEST_F(ResyncOfSequences, DoesNotTakeTrueSamplesForRepairsForEver) {
  accepts(1'000, 1'000);
  for (std::uint64_t n = 1; n < SequenceMonitor::late_in_a_row; ++n) accepts(n, n);
  now += 250ms;
  EXPECT_EQ(monitor.numbering(), 0U);
  accepts(SequenceMonitor::late_in_a_row, SequenceMonitor::late_in_a_row);
  EXPECT_EQ(monitor.numbering(), 1U);
  EXPECT_FALSE(monitor.newest_was_wrong()) << "it may be a long repair";
}

TEST_F(ResyncOfSequences, KnowsByTheirStampsWhatWasPublishedAfterAWrongSequenceCame) {
  const auto observed = [&](std::uint64_t sequence, SequenceMonitor::Time published,
                            std::uint64_t place = 0) {
    const std::chrono::nanoseconds by_its_clock = published.time_since_epoch() + 7h;
    return monitor.accepts({sequence, place, ++datagram, by_its_clock.count()}, now);
  };
  for (std::uint64_t n = 1; n <= 10; ++n, now += 10ms) observed(n, now, n);
  observed(60'000, now + 24h, 1'000);  // The stamp and the place of this sample are wrong, too.
  now += 10ms;
  for (std::uint64_t n = 11; n <= 14; ++n) observed(n, now - 50ms, n);
  now += 300ms;
  observed(15, now - 350ms, 15);
  EXPECT_EQ(monitor.numbering(), 0U) << "these were under way before that";
  observed(16, now, 16);
  now += 250ms;
  observed(17, now, 17);
  EXPECT_EQ(monitor.numbering(), 1U);
  EXPECT_TRUE(monitor.newest_was_wrong());
}

TEST_F(ResyncOfSequences, BelievesNoStampForTheSamplesOfOneDatagramOnly) {
  const auto observed = [&](std::uint64_t sequence, std::chrono::nanoseconds stamp) {
    return monitor.accepts({sequence, 0, datagram, stamp.count()}, now);
  };
  for (std::uint64_t n = 1; n <= 10; ++n, now += 10ms) {
    ++datagram;
    observed(n, n * 10ms);
  }
  ++datagram;
  // A stamp a year ahead, which no publisher sets.
  for (std::uint64_t n = 300; n <= 310; ++n) observed(n, 24h * 365);
  for (std::uint64_t n = 11; n <= 40; ++n, now += 10ms) {
    ++datagram;
    observed(n, n * 10ms);
  }
  EXPECT_EQ(monitor.newest(), 40U);
}

TEST_F(ResyncOfSequences, DoesNotMistakeOvertakingSamplesForANewNumbering) {
  accepts(1'000);
  for (std::uint64_t i = 1; i < 200; ++i) {
    accepts(900 + i);
    accepts(1'000 + i);
  }
  EXPECT_EQ(monitor.numbering(), 0U);
}

TEST_F(ResyncOfSequences, WidensToWhatWentOnBeforeAWrongSequenceCame) {
  for (std::uint64_t n = 1; n <= 20; ++n) accepts(n);
  EXPECT_FALSE(accepts(0xffff'fff0));
  now += 250ms;
  EXPECT_TRUE(accepts(0xffff'fff1));
  EXPECT_EQ(monitor.widen(21), 21U);
}

TEST(ResyncOfQueues, TakeLowerSequencesOnceTheNumberingBeganAnew) {
  const auto memory = core::BufferPool::make(std::size_t{1} << 20);
  const auto sample = [&](std::uint64_t sequence, std::uint32_t numbering) {
    core::SampleHandle made = memory->take(sizeof(SampleHeader));
    made->header().sequence = made->sequence = sequence;
    made->numbering = numbering;
    return made;
  };
  KeepLastQueue queue(4);
  core::SampleHandle wrong = sample(60'000, 0), late = sample(5, 0), anew = sample(5, 1), next = sample(6, 1);
  queue.put(wrong, 1);
  queue.pop();
  EXPECT_EQ(queue.put(late, 2), KeepLastQueue::Put::late);
  EXPECT_EQ(queue.put(anew, 3), KeepLastQueue::Put::kept);
  EXPECT_EQ(queue.put(next, 4), KeepLastQueue::Put::kept);
  EXPECT_EQ(queue.pop()->sequence, 5U);
  core::SampleHandle waits = sample(70'000, 1), again = sample(7, 2);
  queue.put(waits, 5);
  EXPECT_EQ(queue.put(again, 6), KeepLastQueue::Put::kept);
  EXPECT_EQ(queue.take_dropped(), 1U) << "what waits under a wrong sequence is dropped, and counted";
  EXPECT_EQ(queue.size(), 2U);
}

class ResyncOfChannels : public testing::Test {
 protected:
  using Verdict = ChannelMonitor::Verdict;
  Verdict evaluate(std::uint32_t channel, std::uint64_t ordinal) {
    return monitor.evaluate({channel, ordinal, ordinal}, now);
  }
  ResyncOfChannels() {
    evaluate(100, 1);
    monitor.turn(100, 1);
  }
  ChannelMonitor monitor;
  ChannelMonitor::Time now{1h};
};

TEST_F(ResyncOfChannels, TurnToAChannelThatBeginsAtOnce) {
  EXPECT_EQ(evaluate(100, 5), Verdict::present);
  EXPECT_EQ(evaluate(101, 1), Verdict::turn);
  EXPECT_EQ(evaluate(4'000'000, 64), Verdict::turn);
}

TEST_F(ResyncOfChannels, TurnToAChannelThatIsUnderWayWhenItIsConfirmed) {
  EXPECT_EQ(evaluate(101, 65), Verdict::ignore);
  EXPECT_EQ(evaluate(100, 5), Verdict::present);
  EXPECT_EQ(evaluate(101, 66), Verdict::ignore);
  EXPECT_EQ(evaluate(101, 67), Verdict::turn);
}

TEST_F(ResyncOfChannels, TurnBackWhereTheyLeftWhenOnlyTheFormerOneIsHeard) {
  EXPECT_EQ(monitor.turn(101, 7), 1U);
  evaluate(101, 1);
  EXPECT_EQ(evaluate(100, 7), Verdict::ignore) << "it may have been under way";
  EXPECT_EQ(evaluate(100, 8), Verdict::ignore);
  now += 250ms;
  EXPECT_EQ(evaluate(100, 6), Verdict::ignore) << "that has come";
  EXPECT_EQ(evaluate(100, 9), Verdict::turn);
  EXPECT_EQ(monitor.turn(100, 1), 7U);
}

TEST_F(ResyncOfChannels, TurnBackToAFormerOneThatWasFollowedTooFar) {
  monitor.turn(101, 1'000'000);
  evaluate(101, 1);
  for (std::uint32_t i = 1; i < ChannelMonitor::behind_in_a_row; ++i)
    EXPECT_EQ(evaluate(100, 6 + i), Verdict::ignore) << "these may be late";
  now += 250ms;
  EXPECT_EQ(evaluate(100, 20), Verdict::turn);
  EXPECT_EQ(monitor.turn(100, 1), 20U) << "it goes on with what comes";
}

TEST_F(ResyncOfChannels, DoNotTurnBackForLateOnesWhileThePresentOneIsHeard) {
  monitor.turn(101, 1'000);
  for (std::uint64_t i = 1; i < 100; ++i) {
    now += 100ms;
    EXPECT_EQ(evaluate(100, i), Verdict::ignore);
    EXPECT_EQ(evaluate(100, i), Verdict::ignore);
    EXPECT_EQ(evaluate(101, i), Verdict::present);
  }
}

TEST_F(ResyncOfChannels, DoNotTurnToUnconfirmedChannels) {
  for (std::uint64_t ordinal = 65; ordinal < 200; ++ordinal) {
    EXPECT_EQ(evaluate(200, ordinal), Verdict::ignore);
    EXPECT_EQ(evaluate(300, ordinal), Verdict::ignore);
  }
}

TEST_F(ResyncOfChannels, TakeOneDatagramForOneWitnessWhateverElseItSays) {
  EXPECT_EQ(evaluate(101, 65), Verdict::ignore);
  EXPECT_EQ(monitor.evaluate({101, 66, 66, true}, now), Verdict::ignore);
  EXPECT_EQ(evaluate(101, 67), Verdict::turn);
}

TEST_F(ResyncOfChannels, DoNotTurnBackForALargeSampleThatIsStillUnderWay) {
  monitor.turn(101, 7);
  for (std::uint32_t i = 0; i < 2 * ChannelMonitor::in_a_row; ++i)
    EXPECT_EQ(evaluate(100, 8), Verdict::ignore) << "it is one ordinal";
}

TEST_F(ResyncOfChannels, DoNotTurnBackAtOnceForManyThatAreBehind) {
  monitor.turn(101, 1'000);
  for (std::uint32_t i = 1; i < 2 * ChannelMonitor::in_a_row; ++i)
    EXPECT_EQ(evaluate(100, i), Verdict::ignore) << "they may be late";
}

TEST_F(ResyncOfChannels, TurnBackForTheVeryNextOneOfAFormerChannel) {
  monitor.turn(101, 7);
  EXPECT_EQ(evaluate(100, 7), Verdict::ignore);
  now += 250ms;
  EXPECT_EQ(evaluate(100, 7), Verdict::turn);
}

TEST_F(ResyncOfChannels, TurnBackForManySamplesInARowThatAreNotBehind) {
  monitor.turn(101, 7);
  for (std::uint32_t i = 1; i < ChannelMonitor::in_a_row; ++i)
    EXPECT_EQ(evaluate(100, 6 + i), Verdict::ignore);
  EXPECT_EQ(evaluate(100, 6 + ChannelMonitor::in_a_row), Verdict::turn);
}

TEST_F(ResyncOfChannels, TurnToOneWithTheSameLowBitsNotForTwoDatagrams) {
  constexpr std::uint32_t alike = 100 + (1U << 24);
  EXPECT_EQ(evaluate(alike, 1), Verdict::ignore);
  now += 250ms;
  for (std::uint32_t i = 2; i < ChannelMonitor::alike_in_a_row; ++i)
    EXPECT_EQ(evaluate(alike, i), Verdict::ignore);
  EXPECT_EQ(evaluate(alike, 4), Verdict::turn);
}

TEST_F(ResyncOfChannels, GoOnWhereTheyLeftAChannelLast) {
  monitor.turn(101, 7);
  EXPECT_EQ(monitor.turn(100, 1), 7U);
  monitor.turn(101, 20);
  EXPECT_EQ(monitor.turn(100, 1), 20U);
}

TEST_F(ResyncOfChannels, RememberTheLastEightChannels) {
  for (std::uint32_t channel = 101; channel <= 121; ++channel) monitor.turn(channel, 7);
  EXPECT_EQ(ChannelMonitor(monitor).turn(120, 1), 7U);
  EXPECT_EQ(ChannelMonitor(monitor).turn(113, 1), 7U);
  EXPECT_EQ(ChannelMonitor(monitor).turn(112, 1), 1U) << "this is taken for one that begins";
}

TEST_F(ResyncOfChannels, IgnoreThoseJustBefore) {
  EXPECT_EQ(evaluate(99, 1), Verdict::ignore);
  EXPECT_EQ(evaluate(99, 2), Verdict::ignore);
}

TEST_F(ResyncOfChannels, DoNotTurnToOneWithTheSameLowBitsWhileThePresentOneIsHeard) {
  constexpr std::uint32_t alike = 100 + (1U << 24);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(evaluate(alike, 1), Verdict::ignore);
    EXPECT_EQ(evaluate(alike, 2), Verdict::ignore);
    EXPECT_EQ(evaluate(100, 5), Verdict::present);
  }
  for (std::uint32_t i = 1; i < ChannelMonitor::alike_in_a_row; ++i)
    EXPECT_EQ(evaluate(alike, i), Verdict::ignore);
  now += 250ms;
  EXPECT_EQ(evaluate(alike, 9), Verdict::turn) << "the writer may have had as many channels";
}

TEST_F(ResyncOfChannels, WidenLowBitsToAChannelThatIsKnown) {
  monitor.turn(1'000'000, 1);
  EXPECT_EQ(monitor.widen(1'000'000 % 2048, 2048), 1'000'000U);
  EXPECT_EQ(monitor.widen(100, 2048), 100U);
  EXPECT_EQ(monitor.widen(1'000'001 % 2048, 2048), 1'000'001U);
  EXPECT_EQ(monitor.widen(999'999 % 2048, 2048), 999'999U);
}

TEST(ResyncOfOrdinals, GoBackToWhatWasPassedOverWhenNothingElseComes) {
  OrdinalMonitor monitor;
  OrdinalMonitor::Time now{1h};
  for (std::uint64_t ordinal = 1; ordinal <= 10; ++ordinal) monitor.came(ordinal);
  monitor.advanced();
  EXPECT_TRUE(monitor.has_come(10));
  EXPECT_FALSE(monitor.has_come(11));
  EXPECT_FALSE(monitor.passed_over(10, false, now)) << "that is a repetition";
  for (std::uint32_t i = 1; i < OrdinalMonitor::unconfirmed_by; ++i)
    EXPECT_FALSE(monitor.passed_over(10 + i, false, now)) << "it may come late";
  now += 250ms;
  EXPECT_EQ(monitor.passed_over(30, false, now), 11U);
}

TEST(ResyncOfOrdinals, GoBackAfterManyInARowAndNotBefore) {
  OrdinalMonitor monitor;
  const OrdinalMonitor::Time now{1h};
  monitor.advanced();
  for (std::uint64_t ordinal = 1; ordinal < OrdinalMonitor::passed_over_in_a_row; ++ordinal)
    EXPECT_FALSE(monitor.passed_over(ordinal, false, now));
  EXPECT_EQ(monitor.passed_over(200, false, now), 1U);
  monitor.advanced();
  EXPECT_FALSE(monitor.passed_over(201, false, now));
}

TEST(ResyncOfOrdinals, GoBackAlsoWhereEachSecondDatagramIsOvertaken) {
  OrdinalMonitor monitor;
  OrdinalMonitor::Time now{1h};
  const OrdinalMonitor::Time end = now + OrdinalMonitor::unconfirmed_after;
  EXPECT_FALSE(monitor.passed_over(11, false, now));
  std::uint64_t ordinal = 12;
  for (; now < end; now += 20ms, ordinal += 2) {
    EXPECT_FALSE(monitor.passed_over(ordinal + 1, false, now));
    EXPECT_FALSE(monitor.passed_over(ordinal, false, now));
  }
  EXPECT_EQ(monitor.passed_over(ordinal, false, end), 11U);
}

TEST(ResyncOfOrdinals, GoBackAlsoWhereOneWrongOrdinalFarAheadWasPassedOverAmongThem) {
  OrdinalMonitor monitor;
  OrdinalMonitor::Time now{1h};
  EXPECT_FALSE(monitor.passed_over(11, false, now));
  EXPECT_FALSE(monitor.passed_over(5000, false, now));
  for (std::uint64_t ordinal = 12; ordinal < 12 + OrdinalMonitor::unconfirmed_by - 1; ++ordinal)
    EXPECT_FALSE(monitor.passed_over(ordinal, false, now));
  EXPECT_EQ(monitor.passed_over(30, false, now + OrdinalMonitor::unconfirmed_after), 12U);
}

TEST(ResyncOfOrdinals, RememberWhatCameOnlyAsFarAsTheyCan) {
  OrdinalMonitor monitor;
  monitor.came(1);
  monitor.came(OrdinalMonitor::remembered);
  EXPECT_TRUE(monitor.has_come(1));
  EXPECT_FALSE(monitor.has_come(2));
  monitor.came(OrdinalMonitor::remembered + 1);
  EXPECT_FALSE(monitor.has_come(1));
  monitor.came(std::uint64_t{1} << 62);
  EXPECT_FALSE(monitor.has_come(OrdinalMonitor::remembered));
  EXPECT_TRUE(monitor.has_come(std::uint64_t{1} << 62));
}

TEST(ResyncOfOrdinals, AreConfirmedByOthersNearThem) {
  OrdinalMonitor monitor;
  OrdinalMonitor::Time now{1h};
  EXPECT_FALSE(monitor.confirmed(1'000'000, false, now));
  EXPECT_FALSE(monitor.confirmed(1'000'001, true, now));
  EXPECT_FALSE(monitor.confirmed(2'000'000, false, now));
  EXPECT_TRUE(monitor.confirmed(2'000'001, false, now));
}

}  // namespace
}  // namespace sft::udp
