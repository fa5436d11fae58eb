#include "udp_transport/reliable/resend_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "tests/unit/udp/jobs.h"
#include "tests/unit/udp/messages.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::Image;
using KeptSize = ResendWindow::Size;

constexpr std::uint32_t its_writer = 7, its_channel = 3;

class ResendWindowTest : public testing::Test {
 protected:
  /// Makes a job that holds about `bytes` bytes of memory.
  JobHandle job(std::size_t bytes, std::uint64_t sequence = 1) {
    const FieldMask all = test::fields<Image>("*");
    const Image image = test::make_image(bytes);
    core::SampleHandle sample = memory->take(test::sample_bytes(image, all));
    test::fill(*sample, image, all, its_writer, sequence);
    JobHandle made = jobs->take();
    const TypeSupport& type = test::type_support<Image>();
    made->projection.project(core::state_of(*sample, type.index_slots()), type.type(), all);
    made->mask = std::make_shared<WireMask>(WireMask{5, all.hash(), {}});
    made->sequence = sequence;
    made->first.label = {its_writer, static_cast<std::uint32_t>(sequence), 5};
    made->first.total = static_cast<std::uint32_t>(made->projection.bytes());
    made->sample = std::move(sample);
    return made;
  }
  std::uint64_t keep(std::size_t bytes, std::uint64_t sequence = 1) {
    const JobHandle kept = job(bytes, sequence);
    return window.keep(kept, kept->first).ordinal;
  }
  /// Sends all jobs that may be sent now. Returns their ordinals.
  std::vector<std::uint64_t> send() {
    std::vector<std::uint64_t> sent;
    for (const KeptSize size : {KeptSize::small, KeptSize::large}) {
      while (const auto piece = window.next(size, now)) {
        sent.push_back(piece->ordinal);
        window.finished(*piece, now);
      }
    }
    return sent;
  }
  void ack(std::uint64_t next, std::vector<Missing> missing = {}) {
    Ack ack{.writer = its_writer, .channel = its_channel, .next = next};
    for (const Missing& part : missing) ack.missing[ack.missing_count++] = part;
    window.hear(ack, now);
  }
  std::vector<std::uint64_t> numbers(std::uint64_t first, std::uint64_t last) {
    std::vector<std::uint64_t> all;
    for (std::uint64_t n = first; n <= last; ++n) all.push_back(n);
    return all;
  }

  std::shared_ptr<core::BufferPool> memory = core::BufferPool::make(std::size_t{64} << 20);
  std::shared_ptr<JobPool> jobs = JobPool::make();
  ResendWindow::Time now{1h};
  ResendWindow window{its_writer, its_channel, {.samples = 10, .bytes = 1'000'000}};
};

TEST_F(ResendWindowTest, NumbersSamplesInTheOrderInWhichTheyAreKept) {
  EXPECT_EQ(keep(5, 100), 1U);
  EXPECT_EQ(keep(5, 0x5'0000'0007), 2U);
  const auto first = window.next(KeptSize::small, now);
  const auto second = window.next(KeptSize::small, now);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->first.channel, (ChannelMark{its_channel, 0, 1}));
  EXPECT_EQ(second->first.channel, (ChannelMark{its_channel, 5, 2}));
  EXPECT_TRUE(second->first.flags & channel_follows);
  EXPECT_FALSE(window.next(KeptSize::small, now));
}

TEST_F(ResendWindowTest, LetsGoOfWhatIsAcknowledged) {
  for (int i = 0; i < 5; ++i) keep(5);
  send();
  ack(4);
  EXPECT_EQ(window.kept(), 2U);
  ack(6);
  EXPECT_TRUE(window.settled());
  EXPECT_EQ(window.kept_bytes(), 0U);
}

TEST_F(ResendWindowTest, IgnoresAcksOfWhatWasNeverSentAndOfOthers) {
  for (int i = 0; i < 3; ++i) keep(5);
  ack(2);
  EXPECT_EQ(window.kept(), 3U) << "nothing has been sent";
  send();
  ack(5);
  EXPECT_EQ(window.kept(), 3U);
  window.hear({.writer = its_writer + 1, .channel = its_channel, .next = 3}, now);
  window.hear({.writer = its_writer, .channel = its_channel + 1, .next = 3}, now);
  EXPECT_EQ(window.kept(), 3U);
}

TEST_F(ResendWindowTest, LetsGoOfWhatHasLeftWhereTheOtherEndHasGivenUpOnMore) {
  for (int i = 0; i < 3; ++i) keep(5);
  EXPECT_EQ(send(), numbers(1, 3));
  for (int i = 0; i < 3; ++i) keep(5);
  ack(6);
  EXPECT_EQ(window.kept(), 3U);
  EXPECT_EQ(send(), numbers(4, 6));
}

TEST_F(ResendWindowTest, NamesItsChannelInFullWhileTheOtherEndDoesNotAnswer) {
  const auto in_short = [&] {
    keep(100);
    const auto piece = window.next(KeptSize::small, now);
    window.finished(*piece, now);
    return piece->first.channel.in_short;
  };
  EXPECT_FALSE(in_short());
  ack(2);
  EXPECT_TRUE(in_short());
  int asked = 0;
  for (; asked < 2; now += 1ms) asked += window.heartbeat(now) ? 1 : 0;
  EXPECT_FALSE(in_short());
  ack(3);
  EXPECT_TRUE(in_short());
}

TEST_F(ResendWindowTest, NamesItsChannelInFullAtOnceWhereTheOtherEndFollowsAnother) {
  for (int i = 0; i < 3; ++i) keep(100);
  send();
  while (!window.heartbeat(now)) now += 1ms;
  ack(2);
  now += 30ms;
  window.hear({.writer = its_writer, .channel = its_channel + 2048, .next = 4}, now);
  EXPECT_EQ(window.kept(), 2U);
  EXPECT_TRUE(window.heartbeat(now));
  EXPECT_FALSE(window.heartbeat(now)) << "one for each such ack";
  keep(100);
  const auto piece = window.next(KeptSize::small, now);
  EXPECT_FALSE(piece->first.channel.in_short);
}

TEST_F(ResendWindowTest, RepairsAPartOnceInARoundTripHoweverOftenItIsAskedFor) {
  keep(100, 1);
  keep(200'000, 2);
  send();
  std::size_t repaired = 0;
  for (const auto end = now + 100ms; now < end; now += 1ms) {
    Ack asking{.writer = its_writer, .channel = its_channel, .next = 1};
    asking.missing[0] = {1, 0, 0};
    asking.missing[1] = {2, 50'000, 60'000};
    asking.missing_count = 2;
    window.hear(asking, now, 20ms);
    repaired += send().size();
  }
  EXPECT_EQ(repaired, 2U * 5);
}

TEST(ResendWindowsTest, RepairNoMoreThanFiveHundredAndTwelvePartsThatAreAskedForTogether) {
  ResendWindow window{its_writer, its_channel, {.samples = 1000}};
  const auto jobs = JobPool::make();
  const JobHandle one = test::make_job(*jobs, 1);
  const auto send = [&window] {
    std::size_t sent = 0;
    for (; const auto piece = window.next(KeptSize::small, ResendWindow::Time{1h}); ++sent)
      window.finished(*piece, ResendWindow::Time{1h});
    return sent;
  };
  for (int i = 0; i < 600; ++i) window.keep(one, one->first);
  EXPECT_EQ(send(), 600U);
  for (std::uint32_t ordinal = 1; ordinal <= 600; ++ordinal) {
    Ack ack{.writer = its_writer, .channel = its_channel, .next = 1};
    ack.missing[ack.missing_count++] = {ordinal, 0, 0};
    window.hear(ack, ResendWindow::Time{1h});
  }
  EXPECT_EQ(send(), 512U);
  EXPECT_EQ(window.repairs(), 512U);
}

TEST_F(ResendWindowTest, LetsSmallSamplesOvertakeLargeOnes) {
  keep(500'000);
  keep(50'000);
  keep(50'000);
  EXPECT_EQ(send(), (std::vector<std::uint64_t>{2, 3, 1}));
}

TEST_F(ResendWindowTest, AsksForAnAckNowAndThenOnceItKeepsMuch) {
  for (int i = 0; i < 6; ++i) keep(5);
  send();
  const auto begin = now;
  ASSERT_TRUE(window.heartbeat(begin)) << "the first, which names the port";
  ack(1);
  for (; now < begin + 2s; now += 10ms) {
    EXPECT_FALSE(window.heartbeat(now));
    keep(5);
    send();
  }
  EXPECT_TRUE(window.heartbeat(now));
}

TEST_F(ResendWindowTest, LetsMoreGoWhereALargeSampleIsCutShort) {
  for (int i = 0; i < 7; ++i) keep(100'000);
  EXPECT_EQ(window.kept(), 7U);
  const auto piece = window.next(KeptSize::large, now);
  for (int i = 0; i < 3; ++i) keep(100'000);
  EXPECT_LE(window.kept(), 6U) << "the next one has some time";
  EXPECT_GE(window.kept(), 3U);
  window.finished(*piece, now);
}

TEST_F(ResendWindowTest, AcceptsAnAckOfWhatWasPutBackButHadLeft) {
  keep(5);
  const auto piece = window.next(KeptSize::small, now);
  window.put_back(*piece);
  ack(2);
  EXPECT_TRUE(window.settled());
}

TEST_F(ResendWindowTest, GoesOnWithWhatIsLeftOfASampleThatWasPutBack) {
  keep(500'000);
  auto piece = window.take(1);
  ASSERT_TRUE(piece);
  EXPECT_EQ(piece->range, BodyRange{});
  piece->range.begin = 300'000;
  window.put_back(*piece);
  EXPECT_FALSE(window.all_sent());
  const auto rest = window.next(KeptSize::large, now);
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->range, (BodyRange{.begin = 300'000}));
  window.finished(*rest, now);
  EXPECT_TRUE(window.all_sent());
  ack(1, {{1, 100'000, 200'000}});
  EXPECT_EQ(window.next(KeptSize::large, now)->range, (BodyRange{100'000, 200'000}))
      << "what had left before, too";
}

TEST_F(ResendWindowTest, SendsOnceMoreWhatIsAskedForUnderTheHeaderThatItWasSentWith) {
  keep(3000);
  send();
  ack(1, {{1, 1000, 2000}});
  const auto repair = window.next(KeptSize::small, now);
  ASSERT_TRUE(repair);
  EXPECT_TRUE(repair->is_repair);
  EXPECT_EQ(repair->range, (BodyRange{1000, 2000}));
  EXPECT_EQ(repair->first.label.variant, 5U);
  EXPECT_FALSE(window.next(KeptSize::small, now)) << "once";
}

TEST_F(ResendWindowTest, SendsThePartsThatTwoAcksAskForOnlyOnceWhileTheyWait) {
  keep(3000);
  send();
  ack(1, {{1, 1000, 2000}});
  ack(1, {{1, 1000, 2000}, {1, 1500, 2500}});
  EXPECT_EQ(send(), numbers(1, 1));
}

TEST_F(ResendWindowTest, SendsNothingThatIsAskedForAndWasNotSentOrIsGone) {
  for (int i = 0; i < 3; ++i) keep(5);
  send();
  ack(3);
  keep(200'000);
  ack(3, {{1, 0, 0}, {4, 0, 0}, {9, 0, 0}, {3, UINT32_MAX, UINT32_MAX}});
  EXPECT_EQ(send(), numbers(4, 4)) << "that one for the first time";
}

TEST_F(ResendWindowTest, LetsLiveSamplesGoBetweenRepairs) {
  for (int i = 0; i < 3; ++i) keep(5);
  send();
  for (int i = 0; i < 3; ++i) keep(5);
  ack(1, {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  EXPECT_EQ(send(), (std::vector<std::uint64_t>{1, 4, 2, 5, 3, 6}));
}

TEST_F(ResendWindowTest, DoesNotRepairFasterThanItMay) {
  ResendWindow slow(its_writer, its_channel, {.repair_bytes_per_s = 1'000'000});
  const JobHandle large = job(3'000'000);
  slow.keep(large, large->first);
  slow.finished(*slow.next(KeptSize::large, now), now);
  slow.heartbeat(now);
  const auto ask = [&] {
    slow.hear({.writer = its_writer,
               .channel = its_channel,
               .next = 1,
               .missing = {{{1, 0, 3'000'000}}},
               .missing_count = 1},
              now);
    return slow.next(KeptSize::large, now).has_value();
  };
  EXPECT_TRUE(ask());
  EXPECT_FALSE(ask());
  EXPECT_GT(slow.next_look(now), now);
  now = slow.next_look(now);
  EXPECT_FALSE(now > ResendWindow::Time(1h + 10s));
  now += 3s;
  EXPECT_TRUE(slow.next(KeptSize::large, now));
}

TEST_F(ResendWindowTest, KeepsTheNewestAndCountsWhatWasNeverSent) {
  for (int i = 0; i < 4; ++i) keep(5);
  send();
  for (int i = 0; i < 6; ++i) keep(5);
  EXPECT_EQ(window.kept(), 10U);
  std::size_t dropped = 0;
  for (int i = 0; i < 5; ++i) {
    const JobHandle another = job(5);
    dropped += window.keep(another, another->first).dropped;
  }
  EXPECT_EQ(window.kept(), 10U);
  EXPECT_EQ(dropped, 1U) << "four of these had been sent, and may have come";
}

TEST_F(ResendWindowTest, KeepsWithinItsBytesButAlwaysTheNewest) {
  keep(600'000);
  keep(600'000);
  EXPECT_EQ(window.kept(), 1U);
  keep(3'000'000);
  EXPECT_EQ(window.kept(), 1U);
  EXPECT_EQ(send(), numbers(3, 3));
}

TEST_F(ResendWindowTest, BeatsWithTheFirstSampleAndAfterAPauseThatIsLongerThanUsual) {
  EXPECT_EQ(window.next_look(now), ResendWindow::Time::max());
  keep(5);
  EXPECT_FALSE(window.heartbeat(now)) << "nothing was sent";
  send();
  auto heartbeat = window.heartbeat(now);
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->first, 1U);
  EXPECT_EQ(heartbeat->end, 2U);
  ack(2);
  EXPECT_EQ(window.next_look(now), ResendWindow::Time::max()) << "all has come";
  for (int i = 0; i < 5; ++i) {
    now += 100ms;
    EXPECT_FALSE(window.heartbeat(now)) << "the next sample tells of those before it";
    keep(5);
    send();
  }
  EXPECT_FALSE(window.heartbeat(now + 199ms));
  heartbeat = window.heartbeat(now + 200ms);
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->end, 7U);
}

TEST_F(ResendWindowTest, BeatsSoonAfterABurst) {
  for (int i = 0; i < 5; ++i, now += 1ms) keep(5), send();
  ASSERT_TRUE(window.heartbeat(now));
  ack(6);
  now += 10s;
  for (int i = 0; i < 5; ++i, now += 1ms) keep(5), send();
  EXPECT_LE(window.next_look(now), now + 20ms);
}

TEST_F(ResendWindowTest, BeatsEveryTwoSecondsAtMostHoweverUnevenTheSamplesAre) {
  ResendWindow uneven(its_writer, its_channel, {});
  std::uint64_t beats = 0, sent = 0;
  const auto end = now + 100s;
  while (now < end) {
    const JobHandle next = job(5);
    uneven.keep(next, next->first);
    uneven.finished(*uneven.next(KeptSize::small, now), now);
    for (const auto pause = now + (++sent % 3 == 0 ? 700ms : 30ms); now < pause; now += 10ms) {
      if (!uneven.heartbeat(now)) continue;
      ++beats;
      uneven.hear({.writer = its_writer, .channel = its_channel, .next = sent + 1}, now);
    }
  }
  EXPECT_GT(beats, 20U);
  EXPECT_LE(beats, 55U);
}
TEST_F(ResendWindowTest, BeatsAfterEachPauseWhereTheLinkHasLostSomething) {
  keep(5);
  send();
  EXPECT_TRUE(window.heartbeat(now));
  ack(1, {{1, 0, 0}});
  send();
  ack(2);
  keep(5);
  now += 100ms;
  send();
  EXPECT_EQ(window.next_look(now), now + 20ms);
}

TEST_F(ResendWindowTest, BeatsEverMoreSeldomWhileNobodyAnswers) {
  keep(5);
  send();
  std::size_t beats = 0;
  for (const auto end = now + 20s; now < end; now = window.next_look(now))
    beats += window.heartbeat(now) ? 1 : 0;
  EXPECT_GT(beats, 20U);
  EXPECT_LT(beats, 30U);
}

TEST_F(ResendWindowTest, NamesOnlyWhatHasBeenSent) {
  ack(1);
  keep(500'000);
  keep(5);
  const auto small = window.next(KeptSize::small, now);
  const auto large = window.next(KeptSize::large, now);
  ASSERT_TRUE(small && large);
  window.finished(*small, now);
  EXPECT_EQ(window.heartbeat(now)->end, 1U);
  window.finished(*large, now);
  now += 1s;
  EXPECT_EQ(window.heartbeat(now)->end, 3U);
}

TEST_F(ResendWindowTest, SaysThatNothingIsLeftWhenItParts) {
  keep(5);
  keep(5);
  EXPECT_EQ(window.parting().first, 3U);
  EXPECT_EQ(window.parting().end, 3U);
}

TEST_F(ResendWindowTest, CountsBeyond32Bits) {
  ResendWindow far(its_writer, its_channel, {.samples = 10}, 0xffff'ffff);
  for (int i = 0; i < 3; ++i) {
    const JobHandle next = job(5);
    far.keep(next, next->first);
    far.finished(*far.next(KeptSize::small, now), now);
  }
  EXPECT_EQ(far.heartbeat(now)->end, 0x1'0000'0002U);
  Ack ack{.writer = its_writer, .channel = its_channel, .next = 0x1'0000'0000};
  ack.missing[ack.missing_count++] = {1, 0, 0};
  far.hear(ack, now);
  EXPECT_EQ(far.kept(), 2U);
  EXPECT_EQ(far.next(KeptSize::small, now)->ordinal, 0x1'0000'0001U);
}

TEST_F(ResendWindowTest, RepairsWhatWasSentElsewhereOnceThatHasLeft) {
  const JobHandle sample = job(100);
  const auto kept = window.keep(sample, sample->first, true);
  EXPECT_TRUE(kept.elsewhere);
  EXPECT_EQ(send(), numbers(1, 0)) << "nothing of it is sent here";
  ack(1, {{1, 0, 0}});
  EXPECT_EQ(send(), numbers(1, 0)) << "it is still under way there";
  EXPECT_FALSE(window.sent_elsewhere(1));
  window.departed(1, now);
  EXPECT_TRUE(window.sent_elsewhere(1));
  ack(1, {{1, 0, 0}});
  EXPECT_EQ(send(), numbers(1, 1));
  ack(2);
  EXPECT_TRUE(window.settled());
}

TEST_F(ResendWindowTest, SendsItselfWhatComesWhileMoreThanHalfOfWhatMayBeKeptIs) {
  for (int i = 1; i <= 6; ++i) {
    const JobHandle sample = job(1000);
    EXPECT_EQ(window.keep(sample, sample->first, true).elsewhere, i <= 5) << i;
  }
  window.departed(6, now);  // the window itself sends sample 6
  EXPECT_EQ(send(), numbers(6, 6));
  for (std::uint64_t i = 1; i <= 5; ++i) window.departed(i, now);
  ack(7);
  const JobHandle small = job(1000), large = job(600'000);
  EXPECT_TRUE(window.keep(small, small->first, true).elsewhere);
  EXPECT_FALSE(window.keep(large, large->first, true).elsewhere);
}

TEST_F(ResendWindowTest, TellsHowManyWereKeptAndHaveNotLeft) {
  keep(5), keep(5), keep(5), keep(5);
  const auto first = window.next(KeptSize::small, now);
  window.finished(*first, now);
  const auto second = window.next(KeptSize::small, now);
  const auto heartbeat = window.heartbeat(now);
  ASSERT_TRUE(heartbeat && second);
  EXPECT_EQ(heartbeat->end, 2U);
  EXPECT_EQ(heartbeat->waiting, 3U);
}

/// Windows that share a limit of memory. The limit of each window alone would allow it to use all of that
/// memory.
class SharedMemoryTest : public ResendWindowTest {
 protected:
  static constexpr std::size_t limit = 1'600'000, bytes = 50'000;
  struct Window {
    ResendWindow window;
    std::uint64_t sequence = 0;
  };
  Window open() { return {{its_writer, its_channel, {}, 1, shared}}; }
  ResendWindow::Kept keep_in(Window& one) {
    const JobHandle kept = job(bytes, ++one.sequence);
    kept->keep();
    return one.window.keep(kept, kept->first);
  }
  void keep_in(Window& one, int samples) {
    while (samples-- > 0) keep_in(one);
  }
  std::shared_ptr<KeptMemory> shared = std::make_shared<KeptMemory>(limit);
  SharedMemoryTest() { jobs = JobPool::make(shared); }
};

TEST_F(SharedMemoryTest, IsKeptByOneAloneUpToAHalf) {
  Window one = open();
  keep_in(one, 1000);
  EXPECT_LE(shared->used(), limit / 2);
  EXPECT_GT(shared->used(), limit * 4 / 10);
}

TEST_F(SharedMemoryTest, IsSharedByThoseThatKeepMuchAndOneShareIsFree) {
  Window first = open(), second = open();
  keep_in(first, 100);
  for (int i = 0; i < 100; ++i) keep_in(first), keep_in(second);
  for (const Window* one : {&first, &second}) {
    EXPECT_LE(one->window.kept_bytes(), limit / 3);
    EXPECT_GT(one->window.kept_bytes(), limit / 5);
  }
}

TEST_F(SharedMemoryTest, IsNotOverdrawnByManyAndEachKeepsItsNewest) {
  std::vector<Window> all;
  for (int i = 0; i < 20; ++i) all.push_back(open());
  for (Window& one : all) keep_in(one, 100);
  EXPECT_LE(shared->used(), 2 * limit);
  for (int i = 0; i < 100; ++i) {
    for (Window& one : all) keep_in(one);
  }
  EXPECT_LE(shared->used(), limit);
  for (Window& one : all) EXPECT_GE(one.window.kept(), 1U);
}

TEST_F(SharedMemoryTest, IsLeftToThoseThatKeepLittle) {
  Window much = open(), little = open();
  keep_in(much, 30);
  for (int i = 0; i < 100; ++i) {
    keep_in(much);
    EXPECT_EQ(keep_in(little).dropped, 0U);
    const auto sent = little.window.next(KeptSize::small, now);
    little.window.finished(*sent, now);
    little.window.hear({.writer = its_writer, .channel = its_channel, .next = sent->ordinal}, now);
    EXPECT_EQ(little.window.kept(), 1U);
  }
}

TEST_F(SharedMemoryTest, CountsASampleOnceThatSeveralKeep) {
  const JobHandle kept = job(bytes);
  kept->keep();
  const std::size_t once = shared->used();
  kept->keep();
  EXPECT_EQ(shared->used(), once);
  EXPECT_GE(once, bytes);
}

TEST_F(SharedMemoryTest, ComesBackWhenNobodyHasASampleAnyMore) {
  {
    Window one = open();
    keep_in(one, 10);
    EXPECT_GT(shared->used(), 10 * bytes);
  }
  EXPECT_EQ(shared->used(), 0U);
}

TEST_F(SharedMemoryTest, LetsAPublisherWaitWhereSomethingWouldHaveToGo) {
  Window one = open();
  keep_in(one, 40);
  EXPECT_FALSE(one.window.can_keep(1, 3 * 66'000));
}

}  // namespace
}  // namespace sft::udp
