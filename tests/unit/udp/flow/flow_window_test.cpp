#include "udp_transport/flow/flow_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/unit/udp/flow/flow_window_fixture.h"
#include "udp_transport/flow/receive_shares.h"

namespace sft::udp::test {
namespace {

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
  get_to_know(200'000);
  send_while_there_is_room();
  EXPECT_EQ(window.room(Size::large, now), 0U);
  EXPECT_GT(window.room(Size::small, now), 0U);
}

TEST_F(FlowWindowTest, MarksSeveralTimesInAWindow) {
  get_to_know(200'000);
  const std::size_t sent = send_while_there_is_room();
  EXPECT_GE(marks.size(), 2U);
  EXPECT_LE(marks.size() * (mark_bytes + report_bytes), sent / 100) << "it costs a percent at most";
}

TEST_F(FlowWindowTest, MarksWhatIsLessThanAMegabytePerSecondOnlyEveryTwoSeconds) {
  get_to_know(159'744);
  for (const std::size_t bytes : {100UL, 5000UL}) {
    const auto period = std::chrono::microseconds(bytes + bytes / 4);
    const auto begin = now;
    std::size_t marked = 0;
    for (int i = 0; i < 4000; ++i, now += period) {
      window.sent(bytes, bytes / 1472 + 1, now);
      take_mark();
      marked += marks.size();
      answer(159'744, 0us);
    }
    EXPECT_LE(marked, static_cast<std::size_t>((now - begin) / 2s)) << bytes;
  }
}

TEST_F(FlowWindowTest, SendsAFewSmallDatagramsAndAMarkToAReceiverThatHasNeverReported) {
  window.announce(32 << 20);
  ASSERT_GT(window.room(Size::small, now), 0U);
  window.sent(100, 1, now);
  EXPECT_TRUE(window.mark(now)) << "the mark leaves with the first datagram";
  std::size_t bytes = 100, datagrams = 1;
  for (; window.room(Size::small, now) >= 100 && datagrams < 1000; ++datagrams, bytes += 100, now += 10us)
    window.sent(100, 1, now);
  EXPECT_EQ(datagrams, 16U);
  EXPECT_EQ(window.room(Size::large, now), 0U);
}

TEST_F(FlowWindowTest, LetsNoMoreThan24KilobytesGoInThoseDatagrams) {
  std::size_t bytes = 0;
  for (std::size_t room; (room = window.room(Size::small, now)) > 0;
       bytes += std::min<std::size_t>(room, 8972))
    window.sent(std::min<std::size_t>(room, 8972), 1, now);
  EXPECT_GT(bytes, 20'000U);
  EXPECT_LE(bytes, 24'000U);
}

TEST_F(FlowWindowTest, SendsToAllUnprovenSocketsOfOneHostTogetherNoMoreThanSixtyFourDatagrams) {
  const auto host = std::make_shared<UnprovenBudget>();
  std::vector<FlowWindow> made_up(100, FlowWindow(flow, FlowLimits{}, 0, host));
  const auto send_what_may_go = [&] {
    std::size_t datagrams = 0;
    for (FlowWindow& one : made_up) {
      for (; one.room(Size::small, now) > 0; ++datagrams) one.sent(100, 1, now);
      while (one.takes_control(now)) ++datagrams;
      EXPECT_EQ(one.room(Size::large, now), 0U);
    }
    return datagrams;
  };
  EXPECT_EQ(send_what_may_go(), UnprovenBudget::datagrams_max);
  now += 900ms;
  EXPECT_EQ(send_what_may_go(), 0U);
  now += 3100ms;
  EXPECT_EQ(send_what_may_go(), 4U);
  FlowWindow other_host(flow, FlowLimits{}, 0, std::make_shared<UnprovenBudget>());
  EXPECT_GT(other_host.room(Size::small, now), 0U);
}

TEST_F(FlowWindowTest, SendsAnHonestSocketBesideMadeUpOnesAsSoonAsItHasReported) {
  const auto host = std::make_shared<UnprovenBudget>();
  window = FlowWindow(flow, FlowLimits{}, 0, host);
  host->spend(UnprovenBudget::datagrams_max, now);
  EXPECT_EQ(window.room(Size::small, now), 0U);
  take_mark();
  ASSERT_FALSE(marks.empty()) << "it is asked";
  EXPECT_TRUE(answer(1'000'000));
  EXPECT_GT(window.room(Size::small, now), 0U);
  EXPECT_EQ(host->left(now), 0U) << "what others were sent is not forgiven";
}

TEST_F(FlowWindowTest, AsksAHostThatNeverAnswersSeldomHoweverManySocketsItIsSaidToHave) {
  const auto host = std::make_shared<UnprovenBudget>();
  std::vector<FlowWindow> made_up(400, FlowWindow(flow, FlowLimits{}, 0, host));
  std::size_t asked = 0;
  const auto ask_for = [&](std::chrono::milliseconds duration) {
    asked = 0;
    for (const auto end = now + duration; now < end; now += 50ms) {
      for (FlowWindow& one : made_up) {
        one.await_room();
        asked += one.mark(now) ? 1 : 0;
        EXPECT_GT(one.next_ready(now), now) << "nobody spins";
      }
    }
  };
  ask_for(20s);
  EXPECT_LE(asked, 400 * FlowLimits{}.unproven_marks + UnprovenBudget::datagrams_max + 20);
  ask_for(20s);
  EXPECT_LE(asked, 21U) << "one in a second";
  EXPECT_GE(asked, 19U);
  host->answered(now);  // another socket of the host has answered
  ask_for(5s);
  EXPECT_GE(asked, 400U) << "the host is there";
}

TEST_F(FlowWindowTest, CountsWhatAnHonestSocketWasSentForNothingOnceItHasReported) {
  const auto host = std::make_shared<UnprovenBudget>();
  window = FlowWindow(flow, FlowLimits{}, 0, host);
  send_while_there_is_room(Size::small, 5'000);
  EXPECT_LT(host->left(now), UnprovenBudget::datagrams_max);
  answer(1'000'000);
  EXPECT_EQ(host->left(now), UnprovenBudget::datagrams_max);
}

TEST_F(FlowWindowTest, SendsOnlyMarksOfALargeSampleUntilTheFirstReportWhichOpensTheWindow) {
  window.announce(32 << 20);
  EXPECT_EQ(send_while_there_is_room(), 0U);
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_TRUE(answer(24'000'000));
  EXPECT_GT(send_while_there_is_room(), 700'000U);
}

TEST_F(FlowWindowTest, AsksAReceiverThatNeverReportsEverMoreSeldomAndSendsItNothing) {
  EXPECT_EQ(send_until(now + 1s), 0U);
  EXPECT_LE(marks.size(), 12U);
  EXPECT_TRUE(window.is_mute(now));
  marks.clear();
  EXPECT_EQ(send_until(now + 1s), 0U);
  EXPECT_GE(marks.size(), 3U);
  EXPECT_LE(marks.size(), 4U);
  send_until(now + 20s);
  marks.clear();
  EXPECT_EQ(send_until(now + 60s), 0U);
  EXPECT_NEAR(static_cast<double>(marks.size()), 30, 1);
  EXPECT_FALSE(window.answers(now));
}

TEST_F(FlowWindowTest, GoesOnAtOnceWhenAReceiverReportsThatWasThoughtToBeMute) {
  send_until(now + 5s);
  ASSERT_TRUE(window.is_mute(now));
  EXPECT_TRUE(answer(200'000));
  EXPECT_FALSE(window.is_mute(now));
  EXPECT_TRUE(window.answers(now));
  EXPECT_GT(send_while_there_is_room(), 100'000U);
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

TEST_F(FlowWindowTest, IsPacedAndMarksNothingWhereNobodyIsAskedToReport) {
  window = FlowWindow(0, {.asks = false});
  constexpr std::size_t quarter = usable_bytes(212'992) / 4;
  EXPECT_NEAR(static_cast<double>(send_while_there_is_room(Size::small)), quarter, 30'000);
  const double expected = 0.1 * 500 * quarter;
  EXPECT_NEAR(static_cast<double>(send_until(now + 100ms)), expected, 0.05 * expected);
  EXPECT_TRUE(marks.empty());
  EXPECT_TRUE(window.answers(now));
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

class MarkPauseTest : public FlowWindowTest {
 protected:
  /// Returns the longest of the pauses before eight unanswered flow marks, in milliseconds.
  std::chrono::milliseconds::rep longest_pause(std::chrono::microseconds there_and_back) {
    send_while_there_is_room();
    answer(200'000, there_and_back);
    send_while_there_is_room();
    std::chrono::milliseconds::rep longest = 0;
    for (int i = 0; i < 8; ++i) {
      const auto before = now;
      while (!window.mark(now)) now += 1ms;
      longest = std::max<std::chrono::milliseconds::rep>(longest, (now - before) / 1ms);
    }
    return longest;
  }
};

TEST_F(MarkPauseTest, IsTenMillisecondsAtMostOnAShortWay) { EXPECT_EQ(longest_pause(1ms), 10); }

TEST_F(MarkPauseTest, IsEightTimesThereAndBackAtMostOnALongerWay) { EXPECT_EQ(longest_pause(4ms), 32); }

TEST_F(MarkPauseTest, IsFiftyMillisecondsAtMostOnALongWay) { EXPECT_EQ(longest_pause(40ms), 50); }

TEST_F(FlowWindowTest, SendsNothingButSomeMarksToAReceiverThatFellSilent) {
  get_to_know(200'000);
  EXPECT_LE(send_until(now + 1s), 200'000U);
  EXPECT_TRUE(window.is_mute(now));
  marks.clear();
  EXPECT_EQ(send_until(now + 10s), 0U);
  EXPECT_GT(marks.size(), 13U);
  EXPECT_LT(marks.size(), 30U);
  EXPECT_EQ(send_until(now + 10s, Size::small), 0U);
}

TEST_F(FlowWindowTest, IsAskedAtLeastEvery750MillisecondsWhereAReceiverFellSilent) {
  get_to_know(200'000);
  send_until(now + 3s);
  for (int i = 0; i < 100; ++i) {
    const auto asked = now;
    marks.clear();
    while (marks.empty()) send_until(now + 1us);
    ASSERT_LE(now - asked, 760ms);
  }
  EXPECT_TRUE(answer(200'000));
  EXPECT_GT(send_while_there_is_room(), 100'000U);
}

TEST_F(FlowWindowTest, DoesNotMarkASlowFlowWhoseAcksComeEveryFourSeconds) {
  get_to_know(200'000);
  window.lives(now);
  take_mark();
  answer(200'000, 0us);
  const auto begin = now;
  std::size_t marked = 0;
  for (; now < begin + 20s; now += 10ms) {
    if ((now - begin) % 4s == 3990ms) window.lives(now);
    window.sent(1000, 1, now);
    take_mark();
    marked += marks.size();
  }
  EXPECT_EQ(marked, 0U);
}

/// A stream of less than a megabyte per second need not wait for reports. But its receiver has to answer a
/// flow mark from time to time.
TEST_F(FlowWindowTest, NoticesThatTheReceiverOfASlowStreamIsGone) {
  get_to_know(200'000);
  std::size_t sent = 0;
  for (const auto end = now + 20s; now < end; now += 10ms) {
    if (window.room(Size::small, now) == 0) continue;
    window.sent(1000, 1, now);
    sent += 1000;
    (void)window.mark(now);
  }
  EXPECT_TRUE(window.is_mute(now));
  EXPECT_LE(sent, 310'000U) << "for three seconds";
}

TEST_F(FlowWindowTest, NoticesThatTheReceiverOfASlowStreamWithAcksIsGoneWithinSixSeconds) {
  get_to_know(200'000);
  window.lives(now);
  const auto gone = now;
  for (; now < gone + 20s && !window.is_mute(now); now += 10ms) {
    window.sent(1000, 1, now);
    (void)window.mark(now);
  }
  EXPECT_LE(now - gone, 6s);
}

TEST_F(FlowWindowTest, IsNotSilentAfterAPauseInWhichOneMarkWasLeftUnanswered) {
  get_to_know(200'000);
  send_while_there_is_room(Size::small, 80'000);
  ASSERT_FALSE(marks.empty());
  marks.clear();
  now += 30s;
  EXPECT_GT(window.room(Size::small, now), 0U);
  window.sent(100, 1, now);
  EXPECT_TRUE(window.mark(now)) << "it is asked again with what comes next";
  EXPECT_GT(window.room(Size::small, now), 0U);
}

TEST_F(FlowWindowTest, IsKeptAliveByAcksOfASlowStream) {
  get_to_know(200'000);
  for (const auto end = now + 20s; now < end; now += 100ms) {
    ASSERT_GT(window.room(Size::small, now), 0U);
    window.sent(1000, 1, now);
    EXPECT_FALSE(window.mark(now));
    window.lives(now);
  }
}

TEST_F(FlowWindowTest, StopsWhereTheHostSaysThatNobodyHasThePort) {
  window.sent(100, 1, now);
  take_mark();
  window.refused(now + 1ms);
  EXPECT_EQ(window.room(Size::small, now + 1ms), 0U);
  EXPECT_TRUE(window.is_mute(now + 1ms));
  now += 251ms;
  take_mark();
  ASSERT_EQ(marks.size(), 2U) << "it is asked again";
  EXPECT_TRUE(answer(200'000)) << "it is back";
  EXPECT_GT(window.room(Size::small, now), 0U);
  window.refused(now + 10ms);
  EXPECT_GT(window.room(Size::small, now + 10ms), 0U) << "it has just reported: the refusal may be forged";
  now += 300ms;
  window.refused(now);
  EXPECT_EQ(window.room(Size::large, now), 0U);
  take_mark();
  EXPECT_EQ(marks.size(), 1U) << "asked at once";
  EXPECT_TRUE(answer(200'000));
  EXPECT_GT(window.room(Size::large, now), 0U);
}

TEST_F(FlowWindowTest, HasToBeAnsweredAnewAtAnotherAddressByWhoeverGotTheMarkThere) {
  window = FlowWindow(flow, {}, 0x1234'5678'9abc'def0);
  get_to_know(200'000);
  send_while_there_is_room();
  const auto before = std::exchange(marks, {});
  window.move(0x0fed'cba9'8765'4321);
  for (const FlowMark& mark : before) EXPECT_FALSE(window.hear(report(mark, 200'000), now));
  EXPECT_EQ(send_while_there_is_room(), 0U);
  ASSERT_EQ(marks.size(), 1U);
  for (const FlowMark& mark : before) EXPECT_FALSE(window.hear(report(mark, 200'000), now));
  EXPECT_TRUE(answer(200'000));
  EXPECT_GT(send_while_there_is_room(), 100'000U);
}

TEST_F(FlowWindowTest, MakesProgressWithAWindowOfNothingAndRecoversWithTheNextReport) {
  get_to_know(24'000'000);
  for (const std::size_t share : {0UL, 1UL}) {
    std::size_t sent = 0;
    const auto go_on_until = [&](auto enough, std::size_t reported) {
      const auto end = now + 1s;
      while (now < end && !enough()) {
        sent += send_while_there_is_room();
        marks.empty() ? now = window.next_ready(now) + 1us : now;
        answer(reported);
      }
    };
    send_while_there_is_room();
    answer(share);
    sent = 0;
    go_on_until([&] { return sent > 1'000'000; }, share);
    EXPECT_GT(sent, 1'000'000U) << "one train after the other";
    const auto honest_from = now;
    go_on_until([&] { return window.window() > 500'000; }, 24'000'000);
    EXPECT_LT(now - honest_from, 10ms);
  }
}

TEST_F(FlowWindowTest, IgnoresReportsThatAnswerNoMark) {
  get_to_know(200'000);
  send_while_there_is_room();
  const std::size_t under_way = window.under_way();
  const FlowMark mark = marks.back();
  const auto expect_ignored = [&](auto change) {
    FlowReport wrong = report(mark, 0);
    change(wrong);
    EXPECT_FALSE(window.hear(wrong, now));
    EXPECT_EQ(window.under_way(), under_way);
    EXPECT_EQ(window.window(), 200'000U);
  };
  expect_ignored([&](FlowReport& wrong) { wrong.position = window.position() + 1; });
  expect_ignored([&](FlowReport& wrong) { wrong.position = 0, wrong.sent_at_ns = 0; });
  expect_ignored([&](FlowReport& wrong) { ++wrong.flow; });
  for (const std::int64_t sent_at : {INT64_MIN, INT64_MAX, std::int64_t{-1}, std::int64_t{0}})
    expect_ignored([&](FlowReport& wrong) { wrong.sent_at_ns = sent_at; });
  EXPECT_TRUE(window.hear(report(mark, 200'000), now));
}

TEST_F(FlowWindowTest, MarksNameTheDatagramsOfTheirOwnConnectionOnly) {
  window.sent(300, 3, now);
  window.sent(500, 5, now, true);
  window.await_room();
  const std::optional<FlowMark> mark = window.mark(now);
  ASSERT_TRUE(mark);
  EXPECT_EQ(mark->datagrams, 3U) << "the receiver counts by connection";
  EXPECT_EQ(mark->position, socket_bytes(800, 8));
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
  EXPECT_EQ(shares.answer(mark, here, {}).came, 4U) << "as if all before the first mark had come";
  for (int i = 0; i < 3; ++i) shares.count(here);
  shares.count(there);
  const FlowReport report = shares.answer(mark, here, {});
  EXPECT_EQ(report.came, 7U);
  EXPECT_EQ(report.position, 3U);
  EXPECT_EQ(report.datagrams, 4U);
  EXPECT_EQ(report.sent_at_ns, 5);
  EXPECT_EQ(shares.answer(mark, there, {}).came, 4U) << "another way";
}

TEST(ReceiveSharesTest, CountsEachDatagramOfSendersThatTakeTurns) {
  ReceiveShares shares(1'000'000);
  const SocketAddress here{5U, 10}, there{6U, 10};
  const FlowMark of_one{.flow = 1, .port = 10, .datagrams = 4},
      of_other{.flow = 2, .port = 10, .datagrams = 7};
  shares.answer(of_one, here, {});
  shares.answer(of_other, there, {});
  for (int i = 0; i < 100; ++i) {
    shares.count(here);
    shares.count(there);
  }
  EXPECT_EQ(shares.answer(of_one, here, {}).came, 104U);
  EXPECT_EQ(shares.answer(of_other, there, {}).came, 107U);
}

TEST(ReceiveSharesTest, ASenderThatWasAtRestIsNotToldOfALoss) {
  FlowWindow window(1, {});
  ReceiveShares shares(1 << 20);
  const SocketAddress from{5U, 10};
  const auto send_and_report = [&](int datagrams, FlowWindow::Time at) {
    for (int i = 0; i < datagrams; ++i) {
      window.sent(1472, 1, at);
      shares.count(from);
    }
    window.await_room();
    const std::optional<FlowMark> mark = window.mark(at);
    if (mark) (void)window.hear(shares.answer(*mark, from, at), at + 100us);
    return mark.has_value();
  };
  const FlowWindow::Time start{1h};
  ASSERT_TRUE(send_and_report(1, start));
  const std::size_t room = window.room(FlowWindow::Size::large, start + 1ms);
  ASSERT_TRUE(send_and_report(100, start + 700ms)) << "longer than a receiver remembers who marks nothing";
  EXPECT_EQ(window.room(FlowWindow::Size::large, start + 701ms), room);
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

TEST(ReceiveSharesTest, GivesOneThatItCannotRememberNextToNothing) {
  ReceiveShares shares(212'992);
  for (std::uint32_t i = 0; i < ReceiveShares::senders_max; ++i)
    shares.answer({.flow = i, .port = 1}, {.ip = i, .port = 1}, {});
  const FlowReport report =
      shares.answer({.flow = 7, .port = 1, .datagrams = 9}, {.ip = 5000U, .port = 1}, {});
  EXPECT_EQ(report.window_bytes, usable_bytes(212'992) / (4 * ReceiveShares::senders_max));
  EXPECT_EQ(report.came, 9U);
}

TEST(ReceiveSharesTest, RemembersNoMoreSendersThanItMay) {
  ReceiveShares shares(212'992);
  for (std::uint32_t i = 0; i < 1000; ++i)
    EXPECT_GT(shares.answer({.flow = i, .port = 1}, {.ip = i, .port = 1}, {}).window_bytes, 0U);
  EXPECT_EQ(shares.senders(), ReceiveShares::senders_max);
}

}  // namespace
}  // namespace sft::udp::test
