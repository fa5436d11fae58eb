// Tests of the way from reports to figures, and from figures to JSON and text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tools/demo/roles/roles.h"
#include "tools/demo/screen/figures.h"
#include "tools/demo/screen/report.h"
#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

SubscriberFigures health() {
  SubscriberFigures s{.name = "health"};
  s.route.reason = "another host";
  s.route.fields = "height, width";
  s.counts.received = 100;
  s.counts.bytes = 8200;
  s.counts.steady_samples = 100;
  s.counts.steady_bytes = 8200;
  s.counts.latency_p50_us = 120.04;
  s.counts.latency_p99_us = 310.5;
  return s;
}

SubscriberFigures detector() {
  SubscriberFigures s = health();
  s.name = "detector";
  s.route.in_shared_memory = true;
  s.route.reason = "same host";
  s.route.all_fields = true;
  s.counts.bytes = 0;
  s.counts.steady_bytes = 0;
  return s;
}

/// Asks for nearly all of every tenth cloud.
SubscriberFigures localiser() {
  SubscriberFigures s = health();
  s.name = "localiser";
  s.route.fields = "width, data";
  s.route.max_rate_hz = 1;
  s.route.withheld = 90;
  s.counts.received = 10;
  s.counts.bytes = 65'421'520;
  s.counts.steady_samples = 10;
  s.counts.steady_bytes = 65'421'520;
  s.counts.latency_p50_us = 12'345;
  return s;
}

RunFigures without_hosts(RunFigures run) {
  run.hosts = 1;
  return run;
}

/// The lines joined, so that a sentence that is broken into lines can be found.
std::string unwrapped(std::vector<std::string> lines) {
  std::string text;
  for (const std::string& line : lines) text += line + " ";
  return text;
}

RunFigures run_of(std::vector<SubscriberFigures> subscribers) {
  return {.input = "generated scene",
          .message_shape = "128 x 1024 points",
          .hz = 10,
          .samples = 100,
          .whole_bytes = 6'291'725,
          .hosts = 5,
          .subscribers = std::move(subscribers)};
}

nlohmann::ordered_json json_of(const RunFigures& run) { return nlohmann::ordered_json::parse(to_json(run)); }

std::vector<std::string> keys_of(const nlohmann::ordered_json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

TEST(Latency, HasNoPercentilesBeforeTheFirstSample) { EXPECT_EQ(percentile_us({}, 0.5), 0); }

TEST(Latency, GivesPercentilesByNearestRank) {
  std::vector<std::int64_t> latencies_ns;
  for (int i = 100; i >= 1; --i) latencies_ns.push_back(1000 * i);
  EXPECT_EQ(percentile_us(latencies_ns, 0.50), 50.0);
  EXPECT_EQ(percentile_us(latencies_ns, 0.99), 99.0);
  EXPECT_EQ(percentile_us(latencies_ns, 1.0), 100.0);
  EXPECT_EQ(percentile_us(latencies_ns, 0.0), 1.0);
}

TEST(Latency, OfOneSampleIsAllPercentiles) {
  EXPECT_EQ(percentile_us({1500}, 0.50), 1.5);
  EXPECT_EQ(percentile_us({1500}, 0.99), 1.5);
}

TEST(Report, InSharedMemoryIsReadAsItWasWritten) {
  Posted<SubscriberReport> posted;
  SubscriberReport read;
  posted.read(read);
  EXPECT_FALSE(read.open);
  posted.write({.open = true, .received = 7});
  posted.read(read);
  EXPECT_TRUE(read.open);
  EXPECT_EQ(read.received, 7U);
}

TEST(Report, HasTextsThatAreCutIfTheyAreTooLong) {
  Text<5> text;
  text = "longer";
  EXPECT_EQ(text.str(), "long");
  text = "a";
  EXPECT_EQ(text.str(), "a");
}

TEST(Figures, OfAReaderThatStillLearnsOrHasReceivedNothingDivideByNothing) {
  SubscriberFigures s = health();
  s.counts = {};
  EXPECT_EQ(s.sent_bytes(), 0);
  EXPECT_EQ(s.saved(6'291'725), 0);
}

TEST(Figures, KeepWhatLearningTookApartFromWhatACloudTakes) {
  SubscriberFigures s = health();
  s.counts.bytes = 30'008'200;
  s.counts.learning_bytes = 30'000'000;
  EXPECT_EQ(s.sent_bytes(), 82.0);
  EXPECT_EQ(run_of({s}).carried().bytes, 30'008'200);
}

TEST(Json, HasExactlyTheseKeysInThisOrder) {
  const nlohmann::ordered_json json = json_of(run_of({health()}));
  EXPECT_THAT(keys_of(json),
              ElementsAre("input", "samples", "hosts", "carried_bytes", "whole_bytes", "subscribers"));
  EXPECT_THAT(
      keys_of(json["subscribers"][0]),
      ElementsAre("name", "transport", "reason", "fields", "requirement", "received", "lost", "withheld",
                  "full_bytes_per_sample", "wire_bytes_per_sample", "learning_bytes", "latency_us"));
}

TEST(Json, HasTheFigures) {
  SubscriberFigures reader = health();
  reader.route.fields = "height, data{x,y}";
  const nlohmann::ordered_json json = json_of(run_of({reader}));
  EXPECT_EQ(json["input"], "generated scene");
  EXPECT_EQ(json["samples"], 100);
  EXPECT_EQ(json["hosts"], 5);
  EXPECT_EQ(json["carried_bytes"], 8200);
  EXPECT_EQ(json["whole_bytes"], 629'172'500);
  const auto& s = json["subscribers"][0];
  EXPECT_EQ(s["fields"], nlohmann::json({"height", "data{x,y}"}));
  EXPECT_EQ(s["requirement"], "declared");
  EXPECT_EQ(s["wire_bytes_per_sample"], 82);
  EXPECT_EQ(s["latency_us"]["p50"], 120.0);
  EXPECT_EQ(s["latency_us"]["p99"], 310.5);
}

TEST(Json, HasNullForWhatWasNotMeasured) {
  SubscriberFigures s = health();
  s.counts.received = 0;
  const nlohmann::ordered_json json = json_of(without_hosts(run_of({s, health()})));
  EXPECT_TRUE(json["subscribers"][0]["latency_us"]["p50"].is_null());
  EXPECT_TRUE(json["subscribers"][1]["wire_bytes_per_sample"].is_null());
  EXPECT_TRUE(json["subscribers"][1]["learning_bytes"].is_null());
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
  Route route;
  route.fields = "height, width";
  EXPECT_EQ(format_request(route), "height, width");
  route.max_rate_hz = 0.5;
  EXPECT_EQ(format_request(route), "height, width, 0.5 Hz");
  route.all_fields = true;
  EXPECT_EQ(format_request(route), "all, 0.5 Hz");
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
  EXPECT_THAT(table[2], AllOf(HasSubstr("width, data, 1 Hz"), HasSubstr("6.54 MB"), HasSubstr("89.6 %")));
  EXPECT_THAT(table[3], AllOf(HasSubstr("detector"), HasSubstr("shm"), HasSubstr("0 B"), HasSubstr("all")));
}

TEST(Table, DoesNotPraiseSavingsThatAreNone) {
  SubscriberFigures s = health();
  s.counts.steady_bytes = 654'215'200;  // headers cost more than the missing field saves
  EXPECT_THAT(format_table(run_of({s}))[1], AllOf(HasSubstr("nothing"), Not(HasSubstr("%"))));
}

TEST(Table, HasNoFiguresOfWhatNobodyHasReceived) {
  SubscriberFigures s = health();
  s.counts.received = 0;
  EXPECT_THAT(format_table(run_of({s}))[1], Not(HasSubstr("%")));
}

TEST(Summary, BeginsWithWhatWasCarriedInsteadOfWhat) {
  EXPECT_EQ(format_summary(run_of({health(), localiser(), detector()}))[0],
            "The network carried 65.43 MB instead of 1.26 GB: 94.8 % saved; nothing lost.");
}

TEST(Summary, SaysFirstOfAllThatSomethingWasLostOrNothingSaved) {
  SubscriberFigures s = health();
  s.counts.lost = 1234;
  s.counts.bytes = 700'000'000;
  EXPECT_EQ(format_summary(run_of({s}))[0], "The network carried 700.00 MB: nothing saved; 1,234 lost.");
  RunFigures stopped = run_of({health()});
  stopped.samples = 0;
  EXPECT_EQ(format_summary(stopped)[0], "Nothing was published.");
}

TEST(Summary, TellsWhatWasPublishedAndHowItWasMeasured) {
  EXPECT_THAT(unwrapped(format_summary(run_of({health(), detector()}))),
              AllOf(HasSubstr("published 100 clouds (128 x 1024 points"),
                    HasSubstr("629.17 MB would be every whole cloud for each of the 1 subscribers"),
                    HasSubstr("In shared memory nothing is copied or sent."), HasSubstr("network interface"),
                    Not(HasSubstr("seen to read"))));
}

TEST(Summary, OfRecordedFieldsTellsWhatLearningTook) {
  SubscriberFigures s = health();
  s.counts.learning_bytes = 18'900'000;
  RunFigures run = run_of({s});
  run.recorded = true;
  EXPECT_THAT(unwrapped(format_summary(run)),
              AllOf(HasSubstr("seen to read"), HasSubstr("took 18.90 MB of the bytes")));
}

TEST(Summary, SaysPlainlyThatThereWereNoHosts) {
  const std::vector<std::string> lines = format_summary(without_hosts(run_of({health(), detector()})));
  EXPECT_EQ(lines[0], "UDP carried 8.20 kB instead of 629.17 MB: 99.9986 % saved; nothing lost.");
  EXPECT_THAT(unwrapped(lines), AllOf(HasSubstr("over loopback"), Not(HasSubstr("network interface"))));
}

/// Every text and number has the greatest length that makes sense.
RunFigures long_run() {
  SubscriberFigures s = localiser();
  s.name = "dashboard";
  s.route.fields = "fields[].name, fields[].offset, point_step, data";
  s.counts.learning_bytes = 123'450'000;
  s.counts.received = 864'000;
  s.counts.lost = 1'234;
  s.counts.latency_p50_us = 123'456;
  RunFigures run = run_of({s, s, s, s, detector()});
  run.input =
      "a folder/of clouds that/has rather long names in it/and lies somewhere deep/down in the file system";
  run.recorded = true;
  run.samples = 864'000;
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

}  // namespace
}  // namespace sft::demo
