#include "udp_transport/flow/length_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

/// A sender, and a receiver behind a path that takes datagrams up to a length.
class LengthWatchTest : public testing::Test {
 protected:
  void send(std::size_t length) {
    position_ += length;
    watch_.sent(length, now_);
    if (length <= takes_) longest_ = std::max(longest_, length);
  }
  /// What a report says of a mark that is sent now.
  struct Mark {
    std::uint64_t position;
    std::size_t longest;
    LengthWatch::Time at;
  };
  Mark mark() {
    watch_.mark(position_);
    return {position_, std::max<std::size_t>(longest_, mark_bytes), now_};
  }
  std::size_t judge(const Mark& mark) {
    return watch_.judge({.position = mark.position, .longest = static_cast<std::uint32_t>(mark.longest)},
                        mark.at);
  }
  std::size_t judge_now() { return judge(mark()); }

  std::size_t takes_ = 1252;
  std::size_t longest_ = 0;
  std::uint64_t position_ = 0;
  LengthWatch::Time now_{1h};
  LengthWatch watch_;
};

TEST_F(LengthWatchTest, TellsTheLengthOfDatagramsThatDidNotArriveWhereShorterOnesDid) {
  send(100);
  send(1472);
  EXPECT_EQ(judge_now(), 1472U);
  EXPECT_TRUE(watch_.in_doubt());
}

TEST_F(LengthWatchTest, TellsItAlsoWhereNothingButMarksArrives) {
  send(1472);
  EXPECT_EQ(judge_now(), 1472U);
}

TEST_F(LengthWatchTest, IsNotInDoubtWhereAllArrive) {
  takes_ = 1472;
  for (int i = 0; i < 100; ++i) {
    send(1472);
    send(100);
    EXPECT_EQ(judge_now(), 0U);
    EXPECT_FALSE(watch_.in_doubt());
  }
}

TEST_F(LengthWatchTest, TellsTheShortestOfAllThatDidNotArrive) {
  send(1472);
  send(1300);
  EXPECT_EQ(judge_now(), 1300U);
}

TEST_F(LengthWatchTest, TellsTheLongestWhereASomewhatShorterOneArrived) {
  send(1472);
  send(1200);
  EXPECT_EQ(judge_now(), 1472U);
}

TEST_F(LengthWatchTest, JudgesNothingByAReceiverThatDoesNotKnow) {
  send(1472);
  EXPECT_EQ(judge({mark().position, 0, now_}), 0U);
  EXPECT_FALSE(watch_.in_doubt());
}

TEST_F(LengthWatchTest, DoesNotJudgeWhatWasSentBehindTheMark) {
  send(100);
  const Mark before = mark();
  send(1472);
  EXPECT_EQ(judge(before), 0U);
  EXPECT_EQ(judge_now(), 1472U);
}

TEST_F(LengthWatchTest, DoesNotJudgeWhatTheReceiverMayHaveForgotten) {
  send(1472);
  now_ += LengthWatch::judged_within + 1ms;
  EXPECT_EQ(judge_now(), 0U);
}

TEST_F(LengthWatchTest, JudgesThoughEachReportComesAfterFurtherMarks) {
  std::vector<Mark> under_way;
  int told = 0;
  for (int i = 0; i < 20; ++i, now_ += 1ms) {
    send(1472);
    under_way.push_back(mark());
    if (under_way.size() < 4) continue;
    told += judge(under_way.front()) == 1472 ? 1 : 0;
    under_way.erase(under_way.begin());
  }
  EXPECT_GE(told, 4);
}

TEST_F(LengthWatchTest, NoticesThatAPathTakesLessFromNowOnOnceTheReceiverHasForgottenTheFormerOnes) {
  takes_ = 1472;
  send(1472);
  EXPECT_EQ(judge_now(), 0U);
  takes_ = 1252;
  longest_ = 0;
  send(1472);
  EXPECT_EQ(judge_now(), 0U) << "1472 had arrived by the last report";
  send(1472);
  EXPECT_EQ(judge_now(), 1472U);
}

TEST_F(LengthWatchTest, IsInDoubtWhileSomethingIsAskedForAgainUntilAReportShowsThatAllArrive) {
  takes_ = 1472;
  send(1472);
  watch_.asked_again();
  EXPECT_TRUE(watch_.in_doubt());
  EXPECT_EQ(judge_now(), 0U);
  EXPECT_FALSE(watch_.in_doubt());
}

}  // namespace
}  // namespace sft::udp
