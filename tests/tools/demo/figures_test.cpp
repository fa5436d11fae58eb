// Tests of the computation of figures from counters, and of figures as JSON and text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tools/demo/figures.h"
#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

SubscriberFigures health() {
  SubscriberFigures s;
  s.name = "health";
  s.metered = true;
  s.transport = "udp";
  s.reason = "another host";
  s.fields = {"height", "width"};
  s.counts = {.samples = 100, .payload_bytes = 1200, .wire_bytes = 8200};
  s.full_bytes = 6'291'725;
  s.p50_us = 120.04;
  s.p99_us = 310.5;
  return s;
}

SubscriberFigures detector() {
  SubscriberFigures s = health();
  s.name = "detector";
  s.transport = "shm";
  s.reason = "same host";
  s.fields = {"header", "height", "width", "fields", "data"};
  s.asks_for_all = true;
  s.counts.wire_bytes = 0;
  return s;
}

/// Returns the figures of a subscriber that requests a part of each tenth sample.
SubscriberFigures localiser() {
  SubscriberFigures s = health();
  s.name = "localiser";
  s.fields = {"data{x,y,z}"};
  s.max_rate_hz = 1;
  s.withheld = 90;
  s.counts = {.samples = 10, .payload_bytes = 62'917'200, .wire_bytes = 65'421'520};
  s.p50_us = 12'345;
  return s;
}

/// Returns the figures of a subscriber whose first three samples were whole, before its recorded mask had
/// narrowed.
SubscriberFigures recorded_health() {
  SubscriberFigures s = health();
  s.recorded = true;
  s.counts = {.samples = 103, .payload_bytes = 30'000'000 + 1200, .wire_bytes = 30'000'000 + 8200};
  s.learnt = Counts{.samples = 3, .payload_bytes = 30'000'000, .wire_bytes = 30'000'000};
  return s;
}

RunFigures without_hosts(RunFigures run) {
  run.hosts = 1;
  for (SubscriberFigures& s : run.subscribers) s.metered = false;
  return run;
}

/// Returns the lines joined by spaces, so that tests can find a sentence that was broken into lines.
std::string unwrapped(std::vector<std::string> lines) {
  std::string text;
  for (const std::string& line : lines) text += line + " ";
  return text;
}

RunFigures run_of(std::vector<SubscriberFigures> subscribers) {
  RunFigures run;
  run.hz = 10;
  run.samples = 100;
  run.hosts = 5;
  run.subscribers = std::move(subscribers);
  return run;
}

TEST(Measurement, CountsFromTheBeginningOfPublishing) {
  SubscriberFigures s = health();
  s.begin = {.samples = 90, .payload_bytes = 1080, .wire_bytes = 7380};
  EXPECT_EQ(s.bytes(), 820.0);
  EXPECT_EQ(s.bytes_per_sample(), 82.0);
  EXPECT_EQ(s.learning_bytes(), 0.0);
}

TEST(Measurement, DividesBySamplesThatArrived) {
  SubscriberFigures s = health();
  s.counts.samples = 0;
  EXPECT_EQ(s.bytes_per_sample(), std::nullopt);
}

TEST(Measurement, WithoutCountersHasOnlyPayload) {
  SubscriberFigures s = health();
  s.metered = false;
  EXPECT_EQ(s.bytes_per_sample(), 12.0);
  EXPECT_EQ(s.learning_bytes(), std::nullopt);
}

TEST(Measurement, OfARecordedSubscriberKeepsLearningApart) {
  const SubscriberFigures s = recorded_health();
  EXPECT_EQ(s.learning_bytes(), 30'000'000.0);
  EXPECT_EQ(s.bytes_per_sample(), 82.0);
  EXPECT_EQ(s.bytes(), 30'008'200.0);
}

TEST(Measurement, OfARecordedSubscriberThatStillLearnsIsAllLearning) {
  SubscriberFigures s = health();
  s.recorded = true;
  s.counts = {.samples = 2, .payload_bytes = 24, .wire_bytes = 2000};
  EXPECT_EQ(s.learning_bytes(), 2000.0);
  EXPECT_EQ(s.bytes_per_sample(), 1000.0);
}

TEST(Measurement, CountsTheLastSamplesAsLostAtTheEnd) {
  SubscriberFigures s = health();
  s.count_missing_as_lost(102);
  EXPECT_EQ(s.lost, 2U);
}

TEST(Measurement, DoesNotCountWhatWasWithheldForALowerRateAsLost) {
  SubscriberFigures s = localiser();
  s.count_missing_as_lost(102);
  EXPECT_EQ(s.lost, 2U);
}

TEST(Json, HasExactlyTheseKeysInThisOrder) {
  const nlohmann::ordered_json json = to_json(run_of({health()}));
  const std::vector<std::string> run_keys{"samples", "hosts", "carried_bytes", "whole_bytes", "subscribers"};
  const std::vector<std::string> subscriber_keys{"name",
                                                 "transport",
                                                 "reason",
                                                 "fields",
                                                 "requirement",
                                                 "received",
                                                 "lost",
                                                 "withheld",
                                                 "full_bytes_per_sample",
                                                 "wire_bytes_per_sample",
                                                 "learning_bytes",
                                                 "latency_us"};
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys, run_keys);
  keys.clear();
  for (const auto& [key, value] : json["subscribers"][0].items()) keys.push_back(key);
  EXPECT_EQ(keys, subscriber_keys);
}

TEST(Json, HasTheFigures) {
  const nlohmann::ordered_json json = to_json(run_of({health()}));
  EXPECT_EQ(json["samples"], 100);
  EXPECT_EQ(json["hosts"], 5);
  EXPECT_EQ(json["carried_bytes"], 8200);
  EXPECT_EQ(json["whole_bytes"], 629'172'500);
  const auto& s = json["subscribers"][0];
  EXPECT_EQ(s["fields"], nlohmann::json({"height", "width"}));
  EXPECT_EQ(s["requirement"], "declared");
  EXPECT_EQ(s["wire_bytes_per_sample"], 82);
  EXPECT_EQ(s["latency_us"]["p50"], 120.0);
  EXPECT_EQ(s["latency_us"]["p99"], 310.5);
}

TEST(Json, HasNullForWhatWasNotMeasured) {
  SubscriberFigures s = health();
  s.metered = false;
  s.p50_us.reset();
  const nlohmann::ordered_json json = to_json(run_of({s}));
  EXPECT_TRUE(json["subscribers"][0]["wire_bytes_per_sample"].is_null());
  EXPECT_TRUE(json["subscribers"][0]["latency_us"]["p50"].is_null());
}

TEST(Text, HasUnitsThatPeopleRead) {
  EXPECT_EQ(tool::aligned_bytes_text(0), "0 B");
  EXPECT_EQ(tool::aligned_bytes_text(81.6), "82 B");
  EXPECT_EQ(tool::aligned_bytes_text(1570), "1.57 kB");
  EXPECT_EQ(tool::aligned_bytes_text(6'291'725), "6.29 MB");
  EXPECT_EQ(tool::aligned_bytes_text(2.5e9), "2.50 GB");
  EXPECT_EQ(tool::aligned_bytes_text(3e12), "3.00 TB");
  EXPECT_EQ(tool::grouped_count_text(0), "0");
  EXPECT_EQ(tool::grouped_count_text(999), "999");
  EXPECT_EQ(tool::grouped_count_text(1000), "1,000");
  EXPECT_EQ(tool::grouped_count_text(6'291'725), "6,291,725");
}

TEST(Text, NamesFieldsAndARateBehindThem) {
  SubscriberFigures s;
  EXPECT_EQ(format_request(s), "none");
  s.fields = {"height", "data{x,y,z}[::2]"};
  EXPECT_EQ(format_request(s), "height, data{x,y,z}[::2]");
  s.asks_for_all = true;
  s.max_rate_hz = 0.5;
  EXPECT_EQ(format_request(s), "all, 0.5 Hz");
}

TEST(Text, BreaksAtSpacesSoThatNoLineIsTooLong) {
  EXPECT_THAT(tool::lines_of("one two three", 7, tool::LongWords::whole), ElementsAre("one two", "three"));
  EXPECT_THAT(tool::lines_of("one", 7, tool::LongWords::whole), ElementsAre("one"));
  EXPECT_THAT(tool::lines_of("", 7, tool::LongWords::whole), ElementsAre(""));
  EXPECT_THAT(tool::lines_of("a longerword b", 7, tool::LongWords::whole),
              ElementsAre("a", "longerword", "b"));
}

TEST(Text, ThatDoesNotFitEndsWithDots) {
  EXPECT_EQ(tool::shortened("1234567", 7), "1234567");
  EXPECT_EQ(tool::shortened("12345678", 7), "1234...");
}

TEST(Table, HasALineForEachSubscriber) {
  const std::vector<std::string> table = format_table(run_of({health(), localiser(), detector()}));
  ASSERT_EQ(table.size(), 4U);
  EXPECT_THAT(table[1],
              AllOf(HasSubstr("health    height, width"), HasSubstr("82 B"), HasSubstr("99.9986 %")));
  EXPECT_THAT(table[2],
              AllOf(HasSubstr("data{x,y,z}, 1 Hz"), HasSubstr("6.54 MB"), HasSubstr("89.6 %")));
  EXPECT_THAT(table[3], AllOf(HasSubstr("detector"), HasSubstr("shm"), HasSubstr("0 B"), HasSubstr("all")));
}

TEST(Table, DoesNotPraiseSavingsThatAreNone) {
  SubscriberFigures s = health();
  s.counts.wire_bytes = 654'215'200;  // the bytes of the headers exceed those of the missing field
  EXPECT_THAT(format_table(run_of({s}))[1], AllOf(HasSubstr("nothing"), Not(HasSubstr("%"))));
}

TEST(Table, HasNoFiguresOfWhatNobodyHasReceived) {
  SubscriberFigures s = health();
  s.counts = {};
  s.p50_us.reset();
  EXPECT_THAT(format_table(run_of({s}))[1], Not(HasSubstr("%")));
}

TEST(Summary, BeginsWithWhatWasCarriedInsteadOfWhat) {
  EXPECT_EQ(format_summary(run_of({health(), localiser(), detector()}))[0],
            "The network carried 65.43 MB instead of 1.26 GB: 94.8 % saved; nothing lost.");
}

TEST(Summary, SaysFirstOfAllThatSomethingWasLostOrNothingSaved) {
  SubscriberFigures s = health();
  s.lost = 1234;
  s.counts.wire_bytes = 700'000'000;
  EXPECT_EQ(format_summary(run_of({s}))[0], "The network carried 700.00 MB: nothing saved; 1,234 lost.");
  RunFigures stopped = run_of({health()});
  stopped.samples = 0;
  EXPECT_EQ(format_summary(stopped)[0], "Nothing was published.");
}

TEST(Summary, TellsWhatWasPublishedAndHowItWasMeasured) {
  EXPECT_THAT(unwrapped(format_summary(run_of({health(), detector()}))),
              AllOf(HasSubstr("published 100 clouds of a generated yard (6.29 MB each)"),
                    HasSubstr("629.17 MB would be every whole cloud for each of the 1 subscribers"),
                    HasSubstr("In shared memory nothing is copied or sent."), Not(HasSubstr("recorded"))));
}

TEST(Summary, OfRecordedFieldsTellsWhatLearningTook) {
  EXPECT_THAT(unwrapped(format_summary(run_of({recorded_health()}))),
              AllOf(HasSubstr("seen to read"), HasSubstr("took 30.00 MB of the bytes")));
}

TEST(Summary, SaysPlainlyThatThereWereNoHosts) {
  const std::vector<std::string> lines = format_summary(without_hosts(run_of({health(), detector()})));
  EXPECT_EQ(lines[0], "UDP carried 1.20 kB instead of 629.17 MB: 99.9998 % saved; nothing lost.");
  EXPECT_THAT(unwrapped(lines), AllOf(HasSubstr("over loopback"), Not(HasSubstr("network interface"))));
}

/// Returns figures in which every text and number is as long as can be expected.
RunFigures long_run() {
  SubscriberFigures s = localiser();
  s.name = "dashboard";
  s.recorded = true;
  s.fields = {"fields[].name", "fields[].offset", "point_step", "data"};
  s.counts.samples = 864'000;
  s.lost = 1'234;
  s.p50_us = 123'456;
  RunFigures run = run_of({s, s, s, s, detector()});
  run.samples = 864'000;
  run.hosts = 5;
  return run;
}

TEST(Screen, Of80ColumnsAnd24RowsShowsAllOfTheTableAndTheSummary) {
  for (const RunFigures& run : {long_run(), without_hosts(long_run())}) {
    const std::vector<std::string> table = format_table(run);
    const std::vector<std::string> summary = format_summary(run);
    EXPECT_LE(table.size() + summary.size() + 2, 24U) << "with two empty lines, and the prompt behind them";
    for (const auto& lines : {table, summary}) {
      for (const std::string& line : lines) EXPECT_LE(line.size(), columns_max) << line;
    }
    EXPECT_LE(format_progress(run, 86'400).size(), columns_max);
  }
}

TEST(Refusals, AreSaidWithTheirReasonsAndNothingIsSaidWhereThereAreNone) {
  PublisherReport publisher;
  publisher.udp = "io_uring with GRO and GSO, port 7";
  publisher.shm_ready = true;
  EXPECT_THAT(format_refusals(publisher), testing::IsEmpty());
  publisher.udp = "plain sockets with GSO (io_uring cannot be used: it is forbidden here)";
  publisher.shm_ready = false;
  publisher.shm = "/dev/shm is too small";
  EXPECT_THAT(
      format_refusals(publisher),
      ElementsAre(AllOf(HasSubstr("io_uring is not in use"), HasSubstr("it is forbidden here")),
                  AllOf(HasSubstr("Shared memory is not in use"), HasSubstr("/dev/shm is too small"))));
}

}  // namespace
}  // namespace sft::demo
