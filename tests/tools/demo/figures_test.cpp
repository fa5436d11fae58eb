// Tests of the computation of figures from counters, and of figures as JSON and text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "tools/demo/roles/latency.h"
#include "tools/demo/screen/figures.h"
#include "tools/demo/screen/measurement.h"
#include "tools/demo/screen/report.h"
#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

SubscriberReport report(std::uint64_t received, std::uint64_t wire, std::uint64_t control) {
  SubscriberReport r;
  r.transport = "udp";
  r.received = received;
  r.payload_bytes = 12 * received;
  r.traffic.received = wire;
  r.traffic.control_received = control;
  return r;
}

SubscriberFigures health() {
  SubscriberFigures s;
  s.name = "health";
  s.host = "monitor";
  s.transport = "udp";
  s.reason = "another host";
  s.fields = {"height", "width"};
  s.other_fields = {"header", "fields", "data"};
  s.received = 100;
  s.full_bytes_per_sample = 6'291'725;
  s.payload_bytes_per_sample = 12;
  s.payload_bytes = 1200;
  s.wire_bytes_per_sample = 82;
  s.wire_bytes = 8200;
  s.learning_bytes = 0;
  s.latency_p50_us = 120.04;
  s.latency_p99_us = 310.5;
  return s;
}

SubscriberFigures detector() {
  SubscriberFigures s = health();
  s.name = "detector";
  s.host = "lidar";
  s.transport = "shm";
  s.reason = "same host";
  s.fields = {"header", "height", "width", "fields", "data"};
  s.other_fields = {};
  s.wire_bytes_per_sample = 0;
  s.wire_bytes = 0;
  return s;
}

/// Returns the figures of a subscriber that requests all fields except height, and only every tenth sample.
SubscriberFigures localiser() {
  SubscriberFigures s = health();
  s.name = "localiser";
  s.host = "nav";
  s.fields = {"header", "width", "fields", "data"};
  s.other_fields = {"height"};
  s.max_rate_hz = 1;
  s.received = 10;
  s.withheld = 90;
  s.payload_bytes_per_sample = 6'291'720;
  s.payload_bytes = 62'917'200;
  s.wire_bytes_per_sample = 6'542'152;
  s.wire_bytes = 65'421'520;
  s.latency_p50_us = 12'345;
  return s;
}

RunFigures without_hosts(RunFigures run) {
  run.hosts = 1;
  for (SubscriberFigures& s : run.subscribers) {
    s.wire_bytes_per_sample.reset();
    s.wire_bytes.reset();
    s.learning_bytes.reset();
  }
  return run;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
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

TEST(Latency, HasNoPercentilesBeforeTheFirstSample) {
  EXPECT_EQ(LatencyRecord().percentile_us(0.5), std::nullopt);
}

TEST(Latency, GivesPercentilesByNearestRank) {
  LatencyRecord record;
  for (int i = 100; i >= 1; --i) record.add(std::chrono::microseconds(i));
  EXPECT_EQ(record.percentile_us(0.50), 50.0);
  EXPECT_EQ(record.percentile_us(0.99), 99.0);
  EXPECT_EQ(record.percentile_us(1.0), 100.0);
  EXPECT_EQ(record.percentile_us(0.0), 1.0);
}

TEST(Latency, OfOneSampleIsAllPercentiles) {
  LatencyRecord record;
  record.add(std::chrono::nanoseconds(1500));
  EXPECT_EQ(record.percentile_us(0.50), 1.5);
  EXPECT_EQ(record.percentile_us(0.99), 1.5);
}

TEST(Measurement, TakesControlTrafficOffWhatTheInterfaceCounted) {
  const SubscriberFigures s = measure(report(0, 1000, 1000), report(10, 2320, 1500), 10, {.metered = true});
  EXPECT_EQ(s.wire_bytes_per_sample, 82.0);
  EXPECT_EQ(s.payload_bytes_per_sample, 12.0);
  EXPECT_EQ(s.learning_bytes, 0.0);
}

TEST(Measurement, DividesBySamplesThatArrived) {
  EXPECT_EQ(measure(report(0, 0, 0), report(0, 500, 0), 10, {.metered = true}).wire_bytes_per_sample,
            std::nullopt);
}

TEST(Measurement, WithoutCountersHasOnlyPayload) {
  const SubscriberFigures s = measure(report(0, 0, 0), report(10, 0, 0), 10, {.metered = false});
  EXPECT_EQ(s.wire_bytes_per_sample, std::nullopt);
  EXPECT_EQ(s.learning_bytes, std::nullopt);
  EXPECT_EQ(s.payload_bytes_per_sample, 12.0);
}

TEST(Measurement, OfARecordedSubscriberKeepsLearningApart) {
  SubscriberReport now = report(103, 30'000'000 + 8200, 0);
  now.learning = LearningReport{3, 30'000'000, {.received = 30'000'000}};
  now.payload_bytes = 30'000'000 + 1200;
  const SubscriberFigures s = measure(report(0, 0, 0), now, 103, {.recorded = true, .metered = true});
  EXPECT_EQ(s.learning_bytes, 30'000'000.0);
  EXPECT_EQ(s.wire_bytes_per_sample, 82.0);
  EXPECT_EQ(s.payload_bytes_per_sample, 12.0);
}

TEST(Measurement, OfARecordedSubscriberThatStillLearnsIsAllLearning) {
  const SubscriberFigures s =
      measure(report(0, 0, 0), report(2, 2000, 0), 2, {.recorded = true, .metered = true});
  EXPECT_EQ(s.learning_bytes, 2000.0);
  EXPECT_EQ(s.wire_bytes_per_sample, 1000.0);
}

TEST(Measurement, CountsTheLastSamplesAsLostOnlyAtTheEnd) {
  EXPECT_EQ(measure(report(0, 0, 0), report(8, 0, 0), 10, {.is_over = false}).lost, 0U);
  EXPECT_EQ(measure(report(0, 0, 0), report(8, 0, 0), 10, {.is_over = true}).lost, 2U);
}

TEST(Measurement, DoesNotCountWhatWasWithheldForALowerRateAsLost) {
  const SubscriberFigures s =
      measure(report(0, 0, 0), report(8, 0, 0), 100, {.is_over = true, .withheld = 90});
  EXPECT_EQ(s.withheld, 90U);
  EXPECT_EQ(s.lost, 2U);
}

TEST(Measurement, KeepsWhatCameInAllApartFromWhatASampleTook) {
  SubscriberReport now = report(103, 30'000'000 + 8200, 0);
  now.learning = LearningReport{3, 30'000'000, {.received = 30'000'000}};
  const SubscriberFigures s = measure(report(0, 0, 0), now, 103, {.recorded = true, .metered = true});
  EXPECT_EQ(s.wire_bytes, 30'008'200.0);
  EXPECT_EQ(s.wire_bytes_per_sample, 82.0);
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
  s.wire_bytes_per_sample.reset();
  s.latency_p50_us.reset();
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

TEST(Text, NamesFieldsTheShorterWayAndARateBehindThem) {
  SubscriberFigures s;
  EXPECT_EQ(format_request(s), "none");
  s.fields = {"height", "width"};
  EXPECT_EQ(format_request(s), "all");
  s.other_fields = {"header", "data", "fields"};
  EXPECT_EQ(format_request(s), "height, width");
  s.other_fields = {"data"};
  s.max_rate_hz = 0.5;
  EXPECT_EQ(format_request(s), "all but data, 0.5 Hz");
  s.fields = {"header", "data{x,y,z}[::2]"};
  s.other_fields = {"is_dense"};
  EXPECT_EQ(format_request(s), "header, data{x,y,z}[::2], 0.5 Hz") << "a part is not the whole field";
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
  EXPECT_THAT(table[2], AllOf(HasSubstr("all but height, 1 Hz"), HasSubstr("6.54 MB"), HasSubstr("89.6 %")));
  EXPECT_THAT(table[3], AllOf(HasSubstr("detector"), HasSubstr("shm"), HasSubstr("0 B"), HasSubstr("all")));
}

TEST(Table, DoesNotPraiseSavingsThatAreNone) {
  SubscriberFigures s = health();
  s.wire_bytes_per_sample = 6'542'152;  // the bytes of the headers exceed those of the missing field
  EXPECT_THAT(format_table(run_of({s}))[1], AllOf(HasSubstr("nothing"), Not(HasSubstr("%"))));
}

TEST(Table, HasNoFiguresOfWhatNobodyHasReceived) {
  SubscriberFigures s = health();
  s.received = 0;
  s.wire_bytes_per_sample.reset();
  s.latency_p50_us.reset();
  EXPECT_THAT(format_table(run_of({s}))[1], Not(HasSubstr("%")));
}

TEST(Summary, BeginsWithWhatWasCarriedInsteadOfWhat) {
  EXPECT_EQ(format_summary(run_of({health(), localiser(), detector()}))[0],
            "The network carried 65.43 MB instead of 1.26 GB: 94.8 % saved; nothing lost.");
}

TEST(Summary, SaysFirstOfAllThatSomethingWasLostOrNothingSaved) {
  SubscriberFigures s = health();
  s.lost = 1234;
  s.wire_bytes = 700'000'000;
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
  SubscriberFigures s = health();
  s.recorded = true;
  s.learning_bytes = 18'900'000;
  EXPECT_THAT(unwrapped(format_summary(run_of({s}))),
              AllOf(HasSubstr("seen to read"), HasSubstr("took 18.90 MB of the bytes")));
}

TEST(Summary, TellsWhoLostWhat) {
  SubscriberFigures s = health();
  s.lost = 3;
  s.incomplete = 1;
  EXPECT_THAT(joined(format_summary(run_of({s}))), HasSubstr("health lost 3 of 100 (1 came in part)"));
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
  s.learning_bytes = 123'450'000;
  s.fields = {"fields[].name", "fields[].offset", "point_step", "data"};
  s.other_fields = {"header", "height", "width", "is_dense", "row_step", "is_bigendian"};
  s.received = 864'000;
  s.lost = 1'234;
  s.incomplete = 56;
  s.latency_p50_us = 123'456;
  RunFigures run = run_of({s, s, s, s, detector()});
  run.samples = 864'000;
  run.dropped = 77;
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
