#include "udp_transport/flow/length_monitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

/// A sender, and a receiver to which the path carries datagrams of at most the length `takes_`.
class LengthMonitorTest : public testing::Test {
 protected:
  void send(std::size_t length) {
    position_ += length;
    monitor_.sent(length, now_);
    if (length <= takes_) longest_ = std::max(longest_, length);
  }
  /// The fields of the report that answers a flow mark which is sent now.
  struct Mark {
    std::uint64_t position;
    std::size_t longest;
    LengthMonitor::Time at;
  };
  Mark mark() {
    monitor_.mark(position_);
    return {position_, std::max<std::size_t>(longest_, mark_bytes), now_};
  }
  std::size_t evaluate(const Mark& mark) {
    return monitor_.evaluate({.position = mark.position, .longest = static_cast<std::uint32_t>(mark.longest)},
                             mark.at);
  }
  std::size_t evaluate_now() { return evaluate(mark()); }

  std::size_t takes_ = 1252;
  std::size_t longest_ = 0;
  std::uint64_t position_ = 0;
  LengthMonitor::Time now_{1h};
  LengthMonitor monitor_;
};

TEST_F(LengthMonitorTest, FindsTheLengthOfDatagramsThatDidNotArriveWhereShorterOnesDid) {
  send(100);
  send(1472);
  EXPECT_EQ(evaluate_now(), 1472U);
  EXPECT_TRUE(monitor_.is_uncertain());
}

TEST_F(LengthMonitorTest, FindsItAlsoWhereNothingButMarksArrives) {
  send(1472);
  EXPECT_EQ(evaluate_now(), 1472U);
}

TEST_F(LengthMonitorTest, IsCertainWhereAllArrive) {
  takes_ = 1472;
  for (int i = 0; i < 100; ++i) {
    send(1472);
    send(100);
    EXPECT_EQ(evaluate_now(), 0U);
    EXPECT_FALSE(monitor_.is_uncertain());
  }
}

TEST_F(LengthMonitorTest, FindsTheShortestOfAllThatDidNotArrive) {
  send(1472);
  send(1300);
  EXPECT_EQ(evaluate_now(), 1300U);
}

TEST_F(LengthMonitorTest, FindsTheLongestWhereASomewhatShorterOneArrived) {
  send(1472);
  send(1200);
  EXPECT_EQ(evaluate_now(), 1472U);
}

TEST_F(LengthMonitorTest, FindsNothingByAReceiverThatDoesNotReportLengths) {
  send(1472);
  EXPECT_EQ(evaluate({mark().position, 0, now_}), 0U);
  EXPECT_FALSE(monitor_.is_uncertain());
}

TEST_F(LengthMonitorTest, FindsNothingAboutWhatWasSentBehindTheMark) {
  send(100);
  const Mark before = mark();
  send(1472);
  EXPECT_EQ(evaluate(before), 0U);
  EXPECT_EQ(evaluate_now(), 1472U);
}

TEST_F(LengthMonitorTest, FindsNothingAboutWhatTheReceiverMayHaveForgotten) {
  send(1472);
  now_ += LengthMonitor::remembered_for + 1ms;
  EXPECT_EQ(evaluate_now(), 0U);
}

TEST_F(LengthMonitorTest, FindsLossesThoughEachReportComesAfterFurtherMarks) {
  std::vector<Mark> under_way;
  int reports = 0;
  for (int i = 0; i < 20; ++i, now_ += 1ms) {
    send(1472);
    under_way.push_back(mark());
    if (under_way.size() < 4) continue;
    reports += evaluate(under_way.front()) == 1472 ? 1 : 0;
    under_way.erase(under_way.begin());
  }
  EXPECT_GE(reports, 4);
}

TEST_F(LengthMonitorTest, NoticesThatAPathTakesLessFromNowOnOnceTheReceiverHasForgottenTheFormerOnes) {
  takes_ = 1472;
  send(1472);
  EXPECT_EQ(evaluate_now(), 0U);
  takes_ = 1252;
  longest_ = 0;
  send(1472);
  EXPECT_EQ(evaluate_now(), 0U) << "1472 had arrived by the last report";
  send(1472);
  EXPECT_EQ(evaluate_now(), 1472U);
}

TEST_F(LengthMonitorTest, IsUncertainWhileSomethingIsAskedForAgainUntilAReportShowsThatAllArrive) {
  takes_ = 1472;
  send(1472);
  monitor_.asked_again();
  EXPECT_TRUE(monitor_.is_uncertain());
  EXPECT_EQ(evaluate_now(), 0U);
  EXPECT_FALSE(monitor_.is_uncertain());
}

}  // namespace
}  // namespace sft::udp
