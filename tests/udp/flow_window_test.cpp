#include "udp_transport/flow_window.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "udp_transport/receive_shares.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Size = FlowWindow::Size;

constexpr std::uint32_t flow = 7;
constexpr std::size_t batch_datagrams = 10, batch_bytes = 14'720;

class FlowWindowTest : public testing::Test {
 protected:
  /// As the sending thread does; returns socket bytes.
  std::size_t send_while_there_is_room(Size size = Size::large, std::size_t at_most = SIZE_MAX) {
    const std::uint64_t before = window.position();
    while (window.position() - before < at_most && window.room(size, now) > 0) {
      window.sent(batch_bytes, batch_datagrams, now);
      if (const auto mark = window.mark(now)) marks.push_back(*mark);
    }
    return window.position() - before;
  }
  FlowReport report(const FlowMark& mark, std::size_t share) const {
    return {.flow = flow,
            .position = mark.position,
            .window_bytes = static_cast<std::uint32_t>(share),
            .datagrams = mark.datagrams,
            .came = mark.datagrams,
            .sent_at_ns = mark.sent_at_ns};
  }
  /// All marks are answered, so long after they were sent.
  bool answer(std::size_t share, std::chrono::microseconds after = 100us) {
    now += after;
    bool goes_on = false;
    for (const FlowMark& mark : std::exchange(marks, {}))
      goes_on = window.hear(report(mark, share), now) || goes_on;
    return goes_on;
  }

  FlowWindow::Time now{1h};
  std::vector<FlowMark> marks;
  FlowWindow window{flow, FlowLimits{}};
};

TEST_F(FlowWindowTest, BelievesNoSmallerBufferThanEverySystemGrantsAndFillsAQuarter) {
  for (const std::size_t announced : {0UL, 1UL, 1000UL, 212'992UL}) {
    window.announce(announced);
    EXPECT_EQ(window.window(), usable_bytes(212'992) / 4) << announced;
  }
  window.announce(1'000'000);
  EXPECT_EQ(window.window(), usable_bytes(1'000'000) / 4);
}

TEST_F(FlowWindowTest, StopsWhereTheReceiversShareIsUnderWayAndGoesOnWithItsWord) {
  send_while_there_is_room();
  EXPECT_TRUE(answer(200'000));
  EXPECT_GT(send_while_there_is_room(), 100'000U);
  EXPECT_LE(window.under_way(), 200'000U);
  EXPECT_EQ(window.room(Size::large, now), 0U);
  EXPECT_TRUE(answer(200'000));
  EXPECT_GT(send_while_there_is_room(), 100'000U);
}

TEST_F(FlowWindowTest, ObeysAReceiverThatHasLessRoomNow) {
  send_while_there_is_room();
  answer(200'000);
  send_while_there_is_room();
  answer(50'000);
  send_while_there_is_room();
  EXPECT_LE(window.under_way(), 50'000U + socket_bytes(batch_bytes, batch_datagrams));
}

TEST_F(FlowWindowTest, LeavesSomeRoomToSmallSamples) {
  window.announce(1'000'000);
  send_while_there_is_room();
  EXPECT_EQ(window.room(Size::large, now), 0U);
  EXPECT_GT(window.room(Size::small, now), 0U);
}

TEST_F(FlowWindowTest, MarksSeveralTimesInAWindow) {
  window.announce(1'000'000);
  const std::size_t sent = send_while_there_is_room();
  EXPECT_GE(marks.size(), 2U);
  EXPECT_LE(marks.size() * (mark_bytes + report_bytes), sent / 100) << "it costs a percent at most";
}

TEST_F(FlowWindowTest, MarksNothingOfWhatIsLessThanAMegabytePerSecond) {
  window.announce(212'992);
  for (const std::size_t bytes : {100UL, 5000UL}) {
    const auto period = std::chrono::microseconds(bytes + bytes / 4);
    for (int i = 0; i < 1000; ++i, now += period) {
      window.sent(bytes, bytes / 1472 + 1, now);
      EXPECT_FALSE(window.mark(now)) << bytes;
    }
  }
}

TEST_F(FlowWindowTest, AsksWhoHasNeverReportedHoweverFastItMayTakeWhatIsSent) {
  window.announce(8 << 20);
  std::size_t sent = 0;
  for (; !window.mark(now) && sent < 2'000'000;
       now += 1ms) {  // slower than such a buffer is believed to be read
    window.sent(100'000, 1, now);
    sent += 100'000;
  }
  EXPECT_LT(sent, 2'000'000U);
}

TEST_F(FlowWindowTest, WaitsForAReceiverThatIsKeptFromRunning) {
  send_while_there_is_room();
  answer(200'000);
  send_while_there_is_room();
  std::size_t sent = 0;
  for (const auto end = now + 900ms; now < end; now = window.next_ready(now) + 1us)
    sent += send_while_there_is_room();
  EXPECT_EQ(sent, 0U);
}

TEST_F(FlowWindowTest, WaitsForTheFirstReportAndThenGoesOnPacedWhereNobodyReports) {
  const auto send_until = [&](FlowWindow::Time end) {
    std::size_t sent = 0;
    while (now < end) {
      sent += send_while_there_is_room();
      if (const auto mark = window.mark(now)) marks.push_back(*mark);
      now = window.next_ready(now) + 1us;
    }
    return sent;
  };
  constexpr std::size_t quarter = usable_bytes(212'992) / 4;
  const auto begin = now;
  EXPECT_LE(send_until(begin + 50ms), quarter + socket_bytes(batch_bytes, batch_datagrams))
      << "a receiver that has not run yet has lost nothing";
  EXPECT_GE(marks.size(), 3U) << "the mark is repeated";
  const double expected = 0.1 * 500 * quarter;
  EXPECT_NEAR(static_cast<double>(send_until(now + 100ms)), expected, 0.05 * expected);
}

TEST_F(FlowWindowTest, MarksAgainWhereReportsGetLost) {
  send_while_there_is_room();
  answer(200'000);
  send_while_there_is_room();
  marks.clear();
  ASSERT_EQ(window.room(Size::large, now), 0U);
  now = window.next_ready(now);
  const auto mark = window.mark(now);
  ASSERT_TRUE(mark);
  EXPECT_TRUE(window.hear(report(*mark, 200'000), now));
  EXPECT_EQ(window.under_way(), 0U);
}

TEST_F(FlowWindowTest, SendsAWindowNowAndThenToAReceiverThatFellSilent) {
  send_while_there_is_room();
  answer(200'000);
  std::size_t sent = 0;
  for (const auto end = now + 10s; now < end; now = window.next_ready(now) + 1us)
    sent += send_while_there_is_room();
  EXPECT_GT(sent, 1'000'000U);
  EXPECT_LT(sent, 5'000'000U);
}

TEST_F(FlowWindowTest, TriesMoreUntilAQueueBuildsUpOnTheWay) {
  for (int i = 0; i < 20; ++i) {
    send_while_there_is_room();
    answer(24'000'000);
  }
  EXPECT_GT(window.window(), 10'000'000U);
  for (int i = 0; i < 40; ++i) {
    send_while_there_is_room();
    answer(24'000'000, 20ms);
  }
  EXPECT_LT(window.window(), 100'000U);
}

/// 12.5 MB per second.
TEST_F(FlowWindowTest, KeepsTheQueueOfASlowLinkShort) {
  FlowWindow::Time link_free = now;
  FlowWindow::Time::duration longest{};
  for (int i = 0; i < 3000; ++i) {
    send_while_there_is_room(Size::large, 1);
    link_free = std::max(link_free, now) + 1200us;
    if (i > 1000) longest = std::max(longest, link_free - now);
    if (!marks.empty() && link_free > now) {
      const FlowMark mark = marks.front();
      marks.erase(marks.begin());
      now = link_free;
      (void)window.hear(report(mark, 24'000'000), now);
    }
  }
  EXPECT_LT(longest, 15ms);
}

TEST_F(FlowWindowTest, SendsLessWhereMuchGetsLost) {
  send_while_there_is_room();
  answer(24'000'000);
  const std::size_t before = window.window();
  std::uint32_t came = 0;
  for (int i = 0; i < 20; ++i) {
    send_while_there_is_room();
    now += 100us;
    for (const FlowMark& mark : std::exchange(marks, {})) {
      FlowReport half = report(mark, 24'000'000);
      half.came = came += 10;
      (void)window.hear(half, now);
    }
  }
  EXPECT_LT(window.window(), before / 4);
}

/// What is left of the window after twenty reports of the same loss.
std::size_t window_where_gets_lost(double share) {
  FlowWindow window{flow, FlowLimits{}};
  FlowWindow::Time now{1h};
  for (int reports = 0; reports < 20;) {
    while (window.room(Size::large, now) > 0) window.sent(batch_bytes, batch_datagrams, now);
    const auto mark = window.mark(now);
    now += 100us;
    if (!mark) continue;
    const auto came = static_cast<std::uint32_t>(mark->datagrams * (1 - share));
    (void)window.hear({flow, mark->position, 24'000'000, mark->datagrams, came, mark->sent_at_ns}, now);
    ++reports;
  }
  return window.window();
}

TEST(FlowWindowsTest, TakeMoreThanATenthForMuch) {
  constexpr std::size_t first = FlowLimits{}.first_bytes;
  EXPECT_GT(window_where_gets_lost(0), 4 * first);
  EXPECT_GT(window_where_gets_lost(0.05), 4 * first);
  EXPECT_LT(window_where_gets_lost(0.15), first / 4);
  EXPECT_LT(window_where_gets_lost(0.3), first / 4);
}

TEST_F(FlowWindowTest, BecomesSmallerOnceForWhatWasLostTogether) {
  std::uint32_t came = 0;
  std::size_t before = 0, reports = 0;
  for (int round = 0; round < 6; ++round) {  // a small window is marked several times
    before = window.window();
    send_while_there_is_room();
    reports = marks.size();
    now += 100us;
    for (const FlowMark& mark : std::exchange(marks, {})) {
      FlowReport hardly_any = report(mark, 24'000'000);
      hardly_any.came = ++came;
      (void)window.hear(hardly_any, now);
    }
  }
  ASSERT_GE(reports, 2U);
  EXPECT_EQ(window.window(), before / 10 * 7);
}

TEST_F(FlowWindowTest, GrowsLittleWhereThereIsAShortQueueOnTheWay) {
  send_while_there_is_room();
  answer(24'000'000);
  const std::size_t before = window.window();
  for (int i = 0; i < 5; ++i) {
    send_while_there_is_room();
    answer(24'000'000, 2100us);
  }
  EXPECT_GT(window.window(), before);
  EXPECT_LT(window.window(), 2 * before) << "without the queue it would have grown tenfold";
}

TEST_F(FlowWindowTest, GrowsToTheReceiversShareWithinTenTimesThereAndBack) {
  int rounds = 0;
  for (; window.window() < 20'000'000 && rounds < 20; ++rounds) {
    send_while_there_is_room();
    answer(20'000'000);
  }
  EXPECT_LE(rounds, 10);
}

TEST_F(FlowWindowTest, EmptiesTheWayEveryTenSecondsToSeeHowShortItIs) {
  std::size_t before = 0, least = SIZE_MAX;
  const auto go_on_until = [&](FlowWindow::Time end) {
    for (; now < end; now += 9900us) {
      send_while_there_is_room();
      answer(4'000'000);
      least = std::min(least, window.window());
    }
  };
  const auto start = now;
  go_on_until(start + 9s);
  before = window.window();
  EXPECT_EQ(before, 4'000'000U);
  least = SIZE_MAX;
  go_on_until(start + 9900ms);
  EXPECT_EQ(least, before);
  go_on_until(start + 11s);
  EXPECT_LT(least, before * 4 / 5);
  EXPECT_EQ(window.window(), before) << "it grows again at once";
}

TEST_F(FlowWindowTest, BelievesNoReportThatALaterOneOvertook) {
  send_while_there_is_room();
  ASSERT_GE(marks.size(), 1U);
  const FlowMark old = marks.front();
  answer(200'000);
  send_while_there_is_room();
  answer(200'000);
  const std::size_t window_bytes = window.window();
  EXPECT_FALSE(window.hear(report(old, 1), now));
  EXPECT_EQ(window.window(), window_bytes);
}

TEST_F(FlowWindowTest, IgnoresReportsOfWhatWasNeverSentAndOfOthers) {
  send_while_there_is_room();
  const std::size_t under_way = window.under_way();
  FlowReport wrong = report(marks.back(), 1);
  wrong.position = window.position() + 1;
  EXPECT_FALSE(window.hear(wrong, now));
  wrong = report(marks.back(), 1);
  wrong.flow = flow + 1;
  EXPECT_FALSE(window.hear(wrong, now));
  EXPECT_EQ(window.under_way(), under_way);
  wrong = report(marks.back(), 0);
  for (const std::int64_t sent_at : {INT64_MIN, INT64_MAX, std::int64_t{-1}}) {
    wrong.sent_at_ns = sent_at;
    (void)window.hear(wrong, now);
  }
  EXPECT_GT(window.room(Size::large, now), 0U) << "nothing is under way, so something may go";
}

TEST(ReceiveSharesTest, GivesAllWhoSendTheSame) {
  ReceiveShares shares(1'000'000);
  const ReceiveShares::Time now{1h};
  const auto share = [&](std::uint32_t sender, ReceiveShares::Time at) {
    return shares.answer({.flow = sender, .port = 1}, {.ip = 5U, .port = 10}, at).window_bytes;
  };
  EXPECT_EQ(share(1, now), 750'000U);
  EXPECT_EQ(share(2, now), 93'750U) << "the first one does not know of it yet";
  EXPECT_EQ(share(1, now + 1ms), 375'000U);
  EXPECT_EQ(share(2, now + 1ms), 375'000U);
  EXPECT_EQ(share(1, now + 10s), 750'000U) << "the other is at rest";
}

TEST(ReceiveSharesTest, CountsWhatComesFromWhereMarksComeFrom) {
  ReceiveShares shares(1'000'000);
  const SocketAddress here{5U, 10}, there{5U, 11};
  const FlowMark mark{.flow = 1, .port = 1, .position = 3, .datagrams = 4, .sent_at_ns = 5};
  shares.count(here);
  EXPECT_EQ(shares.answer(mark, here, {}).came, 0U);
  for (int i = 0; i < 3; ++i) shares.count(here);
  shares.count(there);
  const FlowReport report = shares.answer(mark, here, {});
  EXPECT_EQ(report.came, 3U);
  EXPECT_EQ(report.position, 3U);
  EXPECT_EQ(report.datagrams, 4U);
  EXPECT_EQ(report.sent_at_ns, 5);
  EXPECT_EQ(shares.answer(mark, there, {}).came, 0U) << "another way";
}

TEST(ReceiveSharesTest, GivesAnAddressWithManyFlowsNoMoreThanOneWithOne) {
  ReceiveShares shares(1'000'000);
  const auto share = [&](std::uint32_t sender, std::uint32_t ip) {
    return shares.answer({.flow = sender, .port = 1}, {.ip = ip, .port = 10}, {}).window_bytes;
  };
  EXPECT_EQ(share(1, 5), 750'000U);
  for (std::uint32_t i = 0; i < 2000; ++i) EXPECT_GT(share(i % 1000, 6), 0U);
  EXPECT_EQ(share(1, 5), 375'000U);
  share(1, 7);
  EXPECT_EQ(share(1, 5), 250'000U) << "who comes later is known as well";
}

TEST(ReceiveSharesTest, RemembersNoMoreSendersThanItMay) {
  ReceiveShares shares(212'992);
  for (std::uint32_t i = 0; i < 1000; ++i)
    EXPECT_GT(shares.answer({.flow = i, .port = 1}, {.ip = i, .port = 1}, {}).window_bytes, 0U);
  EXPECT_EQ(shares.senders(), ReceiveShares::senders_max);
}

}  // namespace
}  // namespace sft::udp
