#include "udp_transport/reliable/arrival_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using Standing = ArrivalWindow::Standing;
using Numbers = std::vector<std::uint64_t>;

class ArrivalWindowTest : public testing::Test {
 protected:
  ArrivalWindowTest() { window.set_readers({1, 2}); }

  Standing meet(std::uint64_t ordinal, std::uint32_t channel = 1) {
    return window.meet({channel, 0, ordinal}, now).standing;
  }
  core::SampleHandle sample(std::uint64_t sequence, std::uint64_t addressee = 0, std::size_t bytes = 100) {
    core::SampleHandle made = memory->take(std::max<std::size_t>(bytes, sizeof(SampleHeader)));
    made->header().body_bytes = static_cast<std::uint32_t>(bytes);
    made->sequence = sequence;
    made->addressee = addressee;
    return made;
  }
  /// Receives a whole sample. The sample's sequence is ten times its ordinal.
  void come(std::uint64_t ordinal, std::uint64_t addressee = 0, std::size_t bytes = 100) {
    const auto met = window.meet({1, 0, ordinal}, now);
    if (met.standing == Standing::wanted) window.whole(met.place, sample(10 * ordinal, addressee, bytes));
  }
  void begin(std::uint64_t ordinal, std::uint64_t addressee = 0) {
    const auto met = window.meet({1, 0, ordinal}, now);
    window.samples().begun(met.place, {1, static_cast<std::uint32_t>(ordinal), 0},
                           sample(10 * ordinal, addressee));
  }
  void hear(std::uint64_t first, std::uint64_t end, std::uint32_t channel = 1) {
    window.hear({.writer = 1, .channel = channel, .port = 1, .first = first, .end = end}, now);
  }
  /// Returns the sequences of the samples that `reader` can take now. A sample is for all readers, or for its
  /// addressee.
  Numbers take(core::EndpointId reader = 1, std::size_t room = 1000) {
    Numbers sequences;
    const auto accepts = [&](const core::SampleBuffer& s, std::uint64_t) {
      return s.addressee == 0 || s.addressee == reader;
    };
    const auto has_room = [&](const core::SampleBuffer&) { return sequences.size() < room; };
    while (const core::SampleHandle next = window.next(reader, accepts, has_room))
      sequences.push_back(next->sequence);
    return sequences;
  }
  Numbers asks(std::size_t at_once_max = 100) {
    Numbers ordinals;
    for (const auto& gap : window.samples().due_gaps(
             now, [&](const SampleLabel&) { return came_at; }, at_once_max, false))
      ordinals.push_back(window.ordinal_of(gap.place));
    return ordinals;
  }

  std::shared_ptr<core::BufferPool> memory = core::BufferPool::make(std::size_t{64} << 20);
  ArrivalWindow::Time now{1h};
  ArrivalWindow::Time came_at = now;
  ArrivalWindow window{{.samples = 100, .held_bytes = 100'000, .awaited_bytes = 300'000, .ack_bytes = 1'000}};
};

TEST_F(ArrivalWindowTest, HandsOverWhatComesInOrderAtOnce) {
  window.set_readers({1});
  come(1);
  EXPECT_EQ(take(), (Numbers{10}));
  come(2);
  EXPECT_EQ(take(), (Numbers{20}));
  window.release();
  EXPECT_EQ(window.samples().slots().size(), 0U);
  EXPECT_EQ(window.samples().held_bytes(), 0U);
}

TEST_F(ArrivalWindowTest, HoldsBackWhatIsBehindAGap) {
  come(1);
  come(3);
  EXPECT_EQ(take(), (Numbers{10}));
  come(2);
  EXPECT_EQ(take(), (Numbers{20, 30}));
}

TEST_F(ArrivalWindowTest, KeepsWhatAReaderHasNoRoomFor) {
  window.set_readers({1, 2});
  for (const std::uint64_t ordinal : {1U, 2U, 3U}) come(ordinal);
  EXPECT_EQ(take(1, 1), (Numbers{10}));
  EXPECT_EQ(take(2), (Numbers{10, 20, 30}));
  window.release();
  EXPECT_TRUE(window.holds_back());
  EXPECT_EQ(take(1), (Numbers{20, 30}));
}

TEST_F(ArrivalWindowTest, KnowsWhatHasCome) {
  come(1);
  begin(2);
  EXPECT_EQ(meet(1), Standing::known);
  EXPECT_EQ(meet(2), Standing::known);
  EXPECT_EQ(meet(3), Standing::wanted);
  take();
  window.release();
  EXPECT_EQ(meet(1), Standing::known);
}

TEST_F(ArrivalWindowTest, WaitsForASampleThatHasBegunOnlyIfItIsForThatReader) {
  begin(1, 2);
  come(2);
  EXPECT_EQ(take(1), (Numbers{20}));
  EXPECT_EQ(take(2), (Numbers{}));
  window.whole(1, sample(10, 2));
  EXPECT_EQ(take(1), (Numbers{}));
  EXPECT_EQ(take(2), (Numbers{10, 20}));
}

TEST_F(ArrivalWindowTest, GoesOnWithoutWhatTheWriterDoesNotHaveAnyMore) {
  come(1);
  begin(3);
  come(4);
  hear(4, 5);
  EXPECT_EQ(take(), (Numbers{10, 40}));
  EXPECT_EQ(window.samples().lost(), 2U);
  ASSERT_EQ(window.samples().dropped().abandoned.size(), 1U) << "that had begun";
}

TEST_F(ArrivalWindowTest, BeginsWhereTheWriterIsByNow) {
  hear(0x1'0000'0005, 0x1'0000'0006);
  EXPECT_EQ(meet(0x1'0000'0004), Standing::known);
  come(0x1'0000'0005);
  EXPECT_EQ(take(), (Numbers{10 * 0x1'0000'0005}));
  EXPECT_EQ(window.ack(1).next, 0x1'0000'0006U);
}

TEST_F(ArrivalWindowTest, TakesNothingThatIsOutOfReach) {
  EXPECT_EQ(meet(101), Standing::beyond);
  EXPECT_EQ(window.samples().slots().size(), 0U);
  EXPECT_EQ(meet(100), Standing::wanted);
  EXPECT_EQ(window.samples().slots().size(), 100U);
}

TEST_F(ArrivalWindowTest, ReachesFurtherAsPlacesAreLetGoOf) {
  hear(1, 500);
  EXPECT_EQ(window.samples().slots().size(), 100U);
  window.set_readers({1});
  for (std::uint64_t ordinal = 1; ordinal < 500; ++ordinal) {
    come(ordinal);
    EXPECT_EQ(take(), (Numbers{10 * ordinal}));
    window.release();
    EXPECT_EQ(window.samples().slots().size(), std::min<std::uint64_t>(100, 499 - ordinal));
  }
}

TEST_F(ArrivalWindowTest, TurnsToANewerChannelAndNotBack) {
  come(1);
  come(3);
  EXPECT_EQ(take(), (Numbers{10}));
  EXPECT_EQ(meet(1, 2), Standing::wanted);
  EXPECT_EQ(take(), (Numbers{30})) << "what is missing of the other will not come any more";
  EXPECT_EQ(meet(2, 1), Standing::beyond);
  EXPECT_EQ(window.ack(1).channel, 2U);
  EXPECT_EQ(window.ack(1).next, 1U);
}

TEST_F(ArrivalWindowTest, AsksForWhatIsMissingAfterAWhileAndThenEverMoreSeldom) {
  come(1);
  come(4);
  EXPECT_EQ(asks(), (Numbers{})) << "it may only have been overtaken";
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{2, 3}));
  EXPECT_EQ(asks(), (Numbers{}));
  std::size_t times = 0;
  for (const auto end = now + 1s; now < end; now = window.next_look()) times += asks().size();
  EXPECT_GT(times, 10U);
  EXPECT_LT(times, 30U);
}

TEST_F(ArrivalWindowTest, AsksForTheLastOnesOnceAHeartbeatTellsOfThem) {
  come(1);
  now += 1s;
  EXPECT_EQ(asks(), (Numbers{}));
  hear(1, 3);
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{2}));
}

TEST_F(ArrivalWindowTest, DoesNotAskForMoreOfASampleWhileItComes) {
  begin(1);
  for (int i = 0; i < 10; ++i) {
    came_at = now += 1ms;
    EXPECT_EQ(asks(), (Numbers{}));
  }
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{1}));
}

TEST_F(ArrivalWindowTest, WaitsLongerWhereWhatItAskedForComesTwice) {
  come(2);
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{1}));
  come(1);
  come(1);
  come(4);
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{}));
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{3}));
}

TEST_F(ArrivalWindowTest, DoublesThePauseBetweenTwoRequestsUpToAQuarterOfASecond) {
  begin(1);
  came_at = {};
  std::vector<std::chrono::milliseconds::rep> pauses;
  for (int i = 0; i < 9; ++i) {
    const auto before = now;
    now = window.next_look();
    EXPECT_EQ(asks(), (Numbers{1}));
    pauses.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(now - before).count());
  }
  EXPECT_EQ(pauses, (std::vector<std::chrono::milliseconds::rep>{2, 4, 8, 16, 32, 64, 128, 250, 250}));
}

TEST_F(ArrivalWindowTest, AsksSoonAgainForASampleThatHasPartlyArrivedMeanwhile) {
  begin(1);
  came_at = {};
  for (int i = 0; i < 9; ++i) {
    now = window.next_look();
    asks();
  }
  EXPECT_EQ(window.next_look(), now + 250ms);
  came_at = now += 250ms;
  EXPECT_EQ(asks(), (Numbers{})) << "more of it may be on its way";
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{1}));
  EXPECT_EQ(window.next_look(), now + 4ms) << "as if it was asked for the first time";
}

/// A network that delays datagrams for a while and later delivers them at once.
class RepairDelayTest : public ArrivalWindowTest {
 protected:
  /// Delays one sample. After its request, the sample arrives `times_that_it_comes` times. Returns the time
  /// until the request.
  ArrivalWindow::Time::duration lose_one(int times_that_it_comes) {
    const auto noticed = now;
    come(ordinal_ + 1);
    now = window.next_look();
    EXPECT_EQ(asks(), (Numbers{ordinal_}));
    for (int i = 0; i < times_that_it_comes; ++i) come(ordinal_);
    EXPECT_EQ(take(1), (Numbers{10 * ordinal_, 10 * ordinal_ + 10}));
    take(2);
    window.release();
    ordinal_ += 2;
    return now - noticed;
  }

 private:
  std::uint64_t ordinal_ = 1;
};

TEST_F(RepairDelayTest, GrowsToNoMoreThanATenthOfASecond) {
  for (int i = 0; i < 20; ++i) lose_one(2);
  EXPECT_EQ(lose_one(2), 100ms);
}

TEST_F(RepairDelayTest, IsShortAgainAfterFortyRepairsThatCameOnce) {
  for (int i = 0; i < 20; ++i) lose_one(2);
  for (int i = 0; i < 40; ++i) lose_one(1);
  EXPECT_EQ(lose_one(1), 2ms);
}

TEST_F(ArrivalWindowTest, AsksForMoreOnlyAsWhatItAskedForComes) {
  hear(1, 101);
  now += 2ms;
  EXPECT_EQ(asks(40).size(), 40U);
  EXPECT_GT(window.next_look(), now);
  now = window.next_look();
  EXPECT_EQ(asks(40), Numbers{});
  for (std::uint64_t ordinal = 1; ordinal <= 3; ++ordinal) come(ordinal);
  EXPECT_EQ(asks(40), (Numbers{41, 42, 43}));
}

TEST_F(ArrivalWindowTest, FallsSilentWhenTheWriterDoes) {
  come(2);
  now += 6s;
  EXPECT_EQ(asks(), (Numbers{}));
  EXPECT_EQ(window.next_look(), ArrivalWindow::Time::max());
  hear(1, 3);
  now += 2ms;
  EXPECT_EQ(asks(), (Numbers{1}));
}

TEST_F(ArrivalWindowTest, AcknowledgesWhatHasComeFromTimeToTimeAndEachHeartbeat) {
  for (std::uint64_t ordinal = 1; ordinal <= 10; ++ordinal) {
    EXPECT_FALSE(window.ack_due());
    come(ordinal);
    take();
    window.release();
  }
  EXPECT_TRUE(window.ack_due());
  const Ack ack = window.ack(9);
  EXPECT_EQ(ack.next, 11U);
  EXPECT_EQ(ack.writer, 9U);
  EXPECT_FALSE(window.ack_due());
  hear(11, 11);
  EXPECT_TRUE(window.ack_due());
}

TEST_F(ArrivalWindowTest, GivesTheOldestUpWhereTooMuchIsHeldBack) {
  for (std::uint64_t ordinal = 2; ordinal <= 6; ++ordinal) come(ordinal, 0, 30'000);
  EXPECT_EQ(take(), (Numbers{20, 30, 40, 50, 60}));
  EXPECT_EQ(window.samples().lost(), 1U);
  EXPECT_EQ(window.ack(1).next, 7U);
}

TEST_F(ArrivalWindowTest, GivesNoMoreUpThanThat) {
  for (const std::uint64_t ordinal : {2U, 3U, 5U, 6U}) come(ordinal, 0, 30'000);
  EXPECT_EQ(take(), (Numbers{20, 30})) << "4 need not be given up";
  come(4, 0, 30'000);
  EXPECT_EQ(take(), (Numbers{40, 50, 60}));
  EXPECT_EQ(window.samples().lost(), 1U);
}

TEST_F(ArrivalWindowTest, GivesNothingUpForWhatItCanHandOver) {
  for (const std::uint64_t ordinal : {2U, 3U}) come(ordinal, 0, 30'000);
  begin(4);
  come(1, 0, 40'000);
  EXPECT_EQ(window.samples().lost(), 0U);
  EXPECT_EQ(take(), (Numbers{10, 20, 30}));
}

TEST_F(ArrivalWindowTest, HandsNothingOverThatItHasGivenUp) {
  begin(1);
  for (std::uint64_t ordinal = 2; ordinal <= 5; ++ordinal) come(ordinal, 0, 30'000);
  EXPECT_EQ(window.samples().lost(), 1U);
  window.whole(1, sample(10));
  EXPECT_EQ(take(), (Numbers{20, 30, 40, 50}));
}

/// Returns the times after which 100 processes request the same missing sample.
std::vector<ArrivalWindow::Time::duration> times_of_asking(bool spread) {
  std::vector<ArrivalWindow::Time::duration> times;
  const ArrivalWindow::Time now{1h};
  std::mt19937 seeds(1);
  for (int i = 0; i < 100; ++i) {
    ArrivalWindow window({.ask_after = 2ms, .spread = 8ms, .seed = static_cast<std::uint32_t>(seeds())});
    if (spread) window.samples().schedule().spread();
    window.meet({1, 0, 2}, now);
    times.push_back(window.next_look() - now);
  }
  std::ranges::sort(times);
  return times;
}

TEST(ArrivalWindowsTest, AskAtTimesOfTheirOwnWhereManyMayMissTheSame) {
  EXPECT_EQ(times_of_asking(false), (std::vector<ArrivalWindow::Time::duration>(100, 2ms)));
  const auto times = times_of_asking(true);
  EXPECT_GE(times.front(), 2ms);
  EXPECT_LT(times.front(), 3ms);
  EXPECT_GT(times[50], 4ms);
  EXPECT_LT(times[50], 8ms);
  EXPECT_GT(times.back(), 9ms);
  EXPECT_LE(times.back(), 10ms);
}

TEST_F(ArrivalWindowTest, LetsGoOfASampleOnlyWhenAllReadersHaveIt) {
  come(1);
  come(2);
  take(1);
  window.release();
  EXPECT_EQ(window.samples().slots().size(), 2U);
  EXPECT_EQ(take(2), (Numbers{10, 20}));
  window.release();
  EXPECT_EQ(window.samples().slots().size(), 0U);
  come(3);
  take(1);
  window.set_readers({1});
  window.release();
  EXPECT_EQ(window.samples().slots().size(), 0U);
}

TEST_F(ArrivalWindowTest, AcknowledgesWhatAllReadersHaveWhereTheWriterWaitsForThem) {
  window.set_awaited(true);
  come(1);
  come(2);
  take(1);
  window.release();
  EXPECT_TRUE(window.holds_back());
  EXPECT_EQ(window.ack(9).next, 1U);
  take(2);
  window.release();
  EXPECT_FALSE(window.holds_back());
  EXPECT_TRUE(window.ack_due()) << "the writer may wait for nothing else";
  EXPECT_EQ(window.ack(9).next, 3U);
  EXPECT_FALSE(window.ack_due());
}

TEST_F(ArrivalWindowTest, KeepsWhatReadersDoNotHaveUntilTheWriterGoesOnWithoutThem) {
  window.set_awaited(true);
  for (std::uint64_t ordinal = 1; ordinal <= 100; ++ordinal) come(ordinal);
  window.release();
  EXPECT_FALSE(window.overtakes());
  EXPECT_EQ(meet(101), Standing::beyond);
  EXPECT_TRUE(window.overtakes());
  EXPECT_EQ(take(1).size(), 100U);
  window.release();
  EXPECT_TRUE(window.overtakes()) << "one of them has nothing yet";
  EXPECT_EQ(take(2).size(), 100U);
  window.release();
  EXPECT_FALSE(window.overtakes());
  EXPECT_EQ(meet(101), Standing::wanted);
  EXPECT_EQ(window.samples().lost(), 0U);
}

TEST_F(ArrivalWindowTest, KeepsNoMoreThanItMayForReadersThatDoNotTakeIt) {
  window.set_awaited(true);
  for (std::uint64_t ordinal = 1; ordinal <= 4; ++ordinal) {
    come(ordinal, 0, 40'000);
    window.release();
    EXPECT_FALSE(window.overtakes()) << "but there is more than may be held back behind a gap";
  }
  come(5, 0, 40'000);
  EXPECT_TRUE(window.overtakes());
  EXPECT_EQ(window.samples().lost(), 0U);
}

TEST_F(ArrivalWindowTest, BeginsForAReaderThatComesLaterWithWhatHasNotComeYet) {
  come(1);
  come(3);
  window.set_readers({1, 2, 3});
  come(2);
  EXPECT_EQ(take(3), (Numbers{20, 30}));
}

TEST_F(ArrivalWindowTest, BeginsAnewWithWhatItHearsFirstWhereItLeftAndJoinsAgain) {
  come(1);
  come(2);
  ArrivalWindow again({.samples = 100});
  again.set_readers({1});
  again.join(*window.mark());
  EXPECT_EQ(again.meet({1, 0, 2}, now).standing, Standing::known);
  const auto met = again.meet({1, 0, 5}, now);
  EXPECT_EQ(met.standing, Standing::wanted);
  again.whole(met.place, sample(50));
  EXPECT_EQ(again.ack(1).next, 6U) << "what was sent meanwhile is not asked for";
  EXPECT_EQ(again.next(1, [](const auto&, std::uint64_t) { return true; })->sequence, 50U);
}

TEST_F(ArrivalWindowTest, MarksWhereItLeftByTheOrdinalsOfTheChannelThatItWasIn) {
  for (std::uint64_t ordinal = 1; ordinal <= 5; ++ordinal) come(ordinal);
  hear(1, 3, 2);
  const auto mark = window.mark();
  ASSERT_TRUE(mark);
  EXPECT_EQ(mark->channel, 2U);
  EXPECT_EQ(mark->end, 3U);
  hear(7, 7, 2);
  EXPECT_EQ(window.mark()->end, 7U);
  EXPECT_FALSE(ArrivalWindow({}).mark()) << "a window that heard nothing was in no channel";
}

TEST_F(ArrivalWindowTest, BeginsWithTheFirstOfANewChannelWhereItJoinsAgain) {
  come(1);
  ArrivalWindow again({.samples = 100});
  again.join(*window.mark());
  EXPECT_EQ(again.meet({2, 0, 2}, now).standing, Standing::wanted);
  EXPECT_EQ(again.ack(1).next, 1U);
}

/// A reader that has changed its request. Samples are sent under the first request unless the test says
/// otherwise.
class ChangingReaderTest : public ArrivalWindowTest {
 protected:
  ChangingReaderTest() { window.set_readers({1}); }
  void come_under(std::uint64_t request, std::uint64_t ordinal) { come(ordinal, request); }
  Numbers take_under_requests() {
    Numbers sequences;
    const auto accepts = [](const core::SampleBuffer& s, std::uint64_t request) {
      return s.addressee >= request;
    };
    while (const core::SampleHandle next = window.next(1, accepts)) sequences.push_back(next->sequence);
    return sequences;
  }
  void hear_of(std::uint64_t end, std::uint32_t waiting) {
    window.hear({.writer = 1, .channel = 1, .port = 1, .first = 1, .end = end, .waiting = waiting}, now);
  }
};

TEST_F(ChangingReaderTest, GetsWhatWasPublishedBeforeUnderTheEarlierRequestHoweverLateItComes) {
  come_under(1, 1);
  window.heard(1, 2);
  hear_of(3, 2);  // samples 3 and 4 have not been sent yet
  for (const std::uint64_t ordinal : {2, 3, 4}) {
    come_under(1, ordinal);
    EXPECT_EQ(take_under_requests().back(), 10 * ordinal);
  }
}

TEST_F(ChangingReaderTest, GetsNothingUnderTheEarlierRequestBehindThat) {
  window.heard(1, 2);
  hear_of(3, 2);
  for (std::uint64_t ordinal = 1; ordinal < 5; ++ordinal) come_under(1, ordinal);
  come_under(1, 5);
  come_under(2, 6);
  EXPECT_EQ(take_under_requests(), (Numbers{10, 20, 30, 40, 60}));
}

TEST_F(ChangingReaderTest, IsNotToldByAHeartbeatOfBefore) {
  hear_of(2, 0);
  window.heard(1, 2);
  for (std::uint64_t ordinal = 1; ordinal < 10; ++ordinal) come_under(1, ordinal);
  EXPECT_EQ(take_under_requests().size(), 9U);
}

TEST_F(ChangingReaderTest, EndsOneRequestAfterTheOtherAsItChangesOftenAndComesBack) {
  window.heard(1, 2);
  hear_of(3, 0);
  window.heard(1, 3);  // Takes effect only after the known end of the second request.
  hear_of(5, 0);
  for (std::uint64_t ordinal = 1; ordinal < 3; ++ordinal) come_under(1, ordinal);
  for (std::uint64_t ordinal = 3; ordinal < 6; ++ordinal) come_under(2, ordinal);
  EXPECT_EQ(take_under_requests().size(), 5U);
  hear_of(8, 0);
  for (std::uint64_t ordinal = 6; ordinal < 10; ++ordinal) come_under(2, ordinal);
  EXPECT_EQ(take_under_requests(), (Numbers{60, 70}));
}

}  // namespace
}  // namespace sft::udp
