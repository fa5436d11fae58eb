// Tests which lines reach a program's log sink, and that repetitions are counted.
#include "core/report/node_log.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class NodeLogTest : public ::testing::Test {
 protected:
  using Lines = std::vector<std::pair<LogLevel, std::string>>;
  NodeLog log_from(LogLevel threshold) {
    return {"node", threshold,
            [this](LogLevel level, std::string_view text) { lines.emplace_back(level, text); }};
  }
  Lines lines;
  const Time now{1h};
};

TEST_F(NodeLogTest, WritesFromItsLevelOn) {
  NodeLog log = log_from(LogLevel::warning);
  log.write(LogLevel::info, "no", now);
  log.write(LogLevel::warning, "yes", now);
  log.write(LogLevel::error, "yes, too", now);
  EXPECT_EQ(lines, (Lines{{LogLevel::warning, "node: yes"}, {LogLevel::error, "node: yes, too"}}));
  EXPECT_FALSE(log.wants(LogLevel::info));
}

TEST_F(NodeLogTest, WithoutASinkWantsNothing) {
  NodeLog log("node", LogLevel::debug, nullptr);
  EXPECT_FALSE(log.wants(LogLevel::error));
  log.write(LogLevel::error, "to nobody", now);
}

TEST_F(NodeLogTest, AnEventNamesItsTopicItsPeerAndItsReason) {
  NodeLog log = log_from(LogLevel::info);
  log.write("points",
            {.kind = Event::Kind::path_changed, .peer = 7, .node = "other", .text = "shm: same host"}, now);
  log.write("points", {.kind = Event::Kind::deadline_missed, .text = "nothing came"}, now);
  log.write("points", {.kind = Event::Kind::incompatible_qos, .text = "incompatible QoS: deadline"}, now);
  log.write("points", {.kind = Event::Kind::request_changed, .text = "for debugging"}, now);
  EXPECT_EQ(lines,
            (Lines{{LogLevel::info, "node: topic 'points', node 'other': path changed: shm: same host"},
                   {LogLevel::warning, "node: topic 'points': deadline missed: nothing came"},
                   {LogLevel::warning, "node: topic 'points': incompatible QoS: deadline"}}));
}

TEST_F(NodeLogTest, WhatWillNeverMatchIsAWarning) {
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::incompatible_qos}), LogLevel::warning);
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::incompatible_type}), LogLevel::warning);
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::no_path}), LogLevel::warning);
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::no_path, .yet = true}), LogLevel::info);
}

TEST_F(NodeLogTest, ABrokenPromiseIsAWarning) {
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::deadline_missed}), LogLevel::warning);
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::samples_lost, .reliable = true}), LogLevel::warning);
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::samples_lost}), LogLevel::info);
}

TEST_F(NodeLogTest, ASampleThatSharedMemoryCannotTakeIsAWarning) {
  EXPECT_EQ(NodeLog::level_of({.kind = Event::Kind::samples_diverted}), LogLevel::warning);
}

TEST_F(NodeLogTest, OfAReliablePairThatLosesSamplesOneLineIsWrittenInASecondAndNoSampleLeftOut) {
  NodeLog log = log_from(LogLevel::warning);
  const Event lost{
      .kind = Event::Kind::samples_lost, .peer = 7, .count = 3, .reliable = true, .text = "3 lost"};
  Event other = lost;
  other.peer = 8;
  for (int i = 0; i < 5; ++i) log.write("points", lost, now + i * 1ms);
  log.write("points", other, now + 5ms);
  EXPECT_EQ(lines, (Lines{{LogLevel::warning, "node: topic 'points': samples lost: 3 lost"},
                          {LogLevel::warning, "node: topic 'points': samples lost: 3 lost"}}))
      << "one of each pair";
  lines.clear();
  log.tick(now + 999ms);
  EXPECT_EQ(lines, Lines{});
  log.write("points", lost, now + 1s);
  EXPECT_EQ(lines, (Lines{{LogLevel::warning,
                           "node: topic 'points': samples lost: 3 lost (12 more were lost before that)"}}));
  lines.clear();
  log.tick(now + 60s);
  EXPECT_EQ(lines, Lines{}) << "all of them are in the log already";
}

TEST_F(NodeLogTest, OfAReliablePairThatGoesOnLosingSamplesLinesBecomeRare) {
  NodeLog log = log_from(LogLevel::warning);
  const Event lost{
      .kind = Event::Kind::samples_lost, .peer = 7, .count = 3, .reliable = true, .text = "3 lost"};
  for (int i = 0; i < 6400; ++i) {
    log.write("points", lost, now + i * 100ms);
    log.tick(now + i * 100ms);
  }
  EXPECT_GE(lines.size(), 10U);
  EXPECT_LE(lines.size(), 18U);
}

TEST_F(NodeLogTest, OfAReliablePairThatLosesSamplesForADayLinesComeAMinuteApartInTheEnd) {
  NodeLog log = log_from(LogLevel::warning);
  const Event lost{
      .kind = Event::Kind::samples_lost, .peer = 7, .count = 3, .reliable = true, .text = "3 lost"};
  for (auto after = 0s; after < 24h; after += 1s) log.write("points", lost, now + after);
  EXPECT_GE(lines.size(), std::size_t{24h / 65s});
}

TEST_F(NodeLogTest, WhatAReliablePairLostBehindItsLastLineIsWrittenASecondAfterThat) {
  NodeLog log = log_from(LogLevel::warning);
  const Event lost{
      .kind = Event::Kind::samples_lost, .peer = 7, .count = 3, .reliable = true, .text = "3 lost"};
  for (int i = 0; i < 2; ++i) log.write("points", lost, now);
  lines.clear();
  for (auto after = 500ms; after < 300s; after += 500ms) log.tick(now + after);
  ASSERT_EQ(lines.size(), 1U) << "they are named once";
  EXPECT_EQ(lines[0].second,
            "node: topic 'points', publisher 0000000000000007: samples lost: 3 more were lost although "
            "reliability was requested");
}

TEST_F(NodeLogTest, OfAFloodAFewLinesAreWrittenThenOneNowAndThenThatSaysHowManyWereNot) {
  NodeLog log = log_from(LogLevel::info);
  for (int i = 0; i < 1000; ++i) log.write(LogLevel::info, "again", now);
  ASSERT_EQ(lines.size(), std::size_t{LineBudget::burst});
  log.write(LogLevel::info, "again", now + LineBudget::period);
  ASSERT_EQ(lines.size(), LineBudget::burst + 1U);
  EXPECT_EQ(lines.back().second, "node: again (990 similar lines were left out)");
  log.write(LogLevel::info, "again", now + LineBudget::period);
  EXPECT_EQ(lines.size(), LineBudget::burst + 1U);
}

TEST_F(NodeLogTest, AWarningIsWrittenOnceAndAgainAfterAPauseThatGrows) {
  NodeLog log = log_from(LogLevel::info);
  std::vector<int> written_at;
  for (int second = 0; second < 3600; ++second) {
    lines.clear();
    log.write(LogLevel::warning, "failed " + std::to_string(second) + " times", now + second * 1s);
    if (!lines.empty()) written_at.push_back(second);
  }
  EXPECT_EQ(written_at, (std::vector{0, 5, 15, 35, 75, 155, 315, 635, 1275, 1915, 2555, 3195}));
}

TEST_F(NodeLogTest, AWarningThatDidNotComeForALongTimeIsWrittenAtOnce) {
  for (const bool ticks : {true, false}) {
    NodeLog log = log_from(LogLevel::info);
    const auto is_written = [&](Time at) {
      lines.clear();
      if (ticks) log.tick(at);
      log.write(LogLevel::warning, "failed", at);
      return !lines.empty();
    };
    EXPECT_TRUE(is_written(now));
    EXPECT_TRUE(is_written(now + 5s));
    EXPECT_FALSE(is_written(now + 14s)) << "the second pause is 10 s long";
    EXPECT_TRUE(is_written(now + 1h));
    EXPECT_TRUE(is_written(now + 1h + 5s)) << "the pauses begin anew";
  }
}

TEST_F(NodeLogTest, ALineCountsThoseThatWereOmittedForThePauseAndThoseThatWereForTheBudget) {
  NodeLog log = log_from(LogLevel::info);
  // Two of these lines are held back by the pause.
  for (int i = 0; i < 3; ++i) log.write(LogLevel::warning, "again", now);
  const std::string others = "abcdefghijkl";  // the budget allows nine of these twelve lines
  for (const char other : others) log.write(LogLevel::warning, std::string(1, other), now);
  ASSERT_EQ(lines.size(), std::size_t{LineBudget::burst});
  log.write(LogLevel::warning, "again", now + LineBudget::period);
  EXPECT_EQ(lines.back().second, "node: again (5 similar lines were left out)");
  log.write(LogLevel::warning, "again", now + 1h);
  EXPECT_EQ(lines.back().second, "node: again") << "they are named once";
}

TEST_F(NodeLogTest, WarningsAboutOtherNamesDoNotWaitForEachOther) {
  NodeLog log = log_from(LogLevel::info);
  for (const char* const text :
       {"topic 'lidar 1': refused", "topic 'lidar 2': refused", "lidar_3 is refused"})
    log.write(LogLevel::warning, text, now);
  EXPECT_EQ(lines.size(), 3U);
}

TEST_F(NodeLogTest, NumbersAreLeftOutOfATextButNotThoseOfNames) {
  EXPECT_EQ(without_numbers("the node's 3 topics 'lidar 1' and lidar2: 12.5 ms"),
            "the node's  topics 'lidar 1' and lidar2: . ms");
}

TEST_F(NodeLogTest, AFloodOfOneTopicHoldsNoOtherTopicBack) {
  NodeLog log = log_from(LogLevel::info);
  for (int i = 0; i < 1000; ++i)
    log.write("camera", {.kind = Event::Kind::samples_diverted, .text = "no chunk"}, now);
  lines.clear();
  log.write("lidar", {.kind = Event::Kind::samples_diverted, .text = "no chunk"}, now);
  EXPECT_EQ(lines.size(), 1U);
}

TEST_F(NodeLogTest, MoreTopicsAndWarningsThanItRemembersAreWrittenAsRarely) {
  NodeLog log = log_from(LogLevel::info);
  const auto write = [&](int number, LogLevel level) {
    const std::string name = "topic" + std::to_string(number);
    log.write(name, {.kind = Event::Kind::matched, .text = "shm: same host"}, now);
    log.write(level, name + " fails", now);
  };
  for (int i = 0; i < 10'000; ++i) write(i, LogLevel::warning);
  EXPECT_LE(lines.size(), 256U + 2 * LineBudget::burst);
}

TEST_F(NodeLogTest, TopicsThatWereQuietForLongLeaveRoomForBudgetsOfOthers) {
  NodeLog log = log_from(LogLevel::info);
  const auto write = [&](const std::string& topic, Time at) {
    log.write(topic, {.kind = Event::Kind::matched, .text = "shm: same host"}, at);
  };
  for (int i = 0; i < 1000; ++i) write("former topic" + std::to_string(i), now);
  log.tick(now + 1h);
  lines.clear();
  constexpr int topics = 5 * LineBudget::burst;
  for (int i = 0; i < topics; ++i) write("topic" + std::to_string(i), now + 1h);
  EXPECT_EQ(lines.size(), std::size_t{topics});
}

TEST_F(NodeLogTest, WarningsThatDidNotComeForLongLeaveRoomForPausesOfOthers) {
  NodeLog log = log_from(LogLevel::info);
  for (int i = 0; i < 1000; ++i) log.write(LogLevel::warning, "former" + std::to_string(i), now);
  log.tick(now + 1h);
  lines.clear();
  for (int i = 0; i < 3; ++i) log.write(LogLevel::warning, "failed", now + 1h);
  EXPECT_EQ(lines.size(), 1U);
}

TEST_F(NodeLogTest, AFloodOfOneKindHoldsNoOtherBack) {
  NodeLog log = log_from(LogLevel::info);
  for (int i = 0; i < 1000; ++i)
    log.write("points", {.kind = Event::Kind::samples_lost, .text = "1 lost"}, now);
  lines.clear();
  log.write("points", {.kind = Event::Kind::matched, .text = "udp: another host"}, now);
  log.write(LogLevel::info, "shared memory: ready", now);
  EXPECT_EQ(lines.size(), 2U);
}

TEST_F(NodeLogTest, AfterAQuietTimeTheBudgetIsWholeAndNoLarger) {
  NodeLog log = log_from(LogLevel::info);
  for (int round = 0; round < 3; ++round) {
    lines.clear();
    for (int i = 0; i < 100; ++i) log.write(LogLevel::info, "again", now + round * 1h);
    EXPECT_EQ(lines.size(), std::size_t{LineBudget::burst});
  }
}

}  // namespace
}  // namespace sft::core
