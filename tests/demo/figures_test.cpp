// From counters to figures, and from figures to JSON and text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "examples/demo/figures.h"
#include "examples/demo/latency.h"
#include "examples/demo/measurement.h"
#include "examples/demo/report.h"

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

SubscriberFigures diagnostic() {
  SubscriberFigures s;
  s.name = "diagnostic";
  s.host = "monitor";
  s.transport = "udp";
  s.reason = "another host";
  s.fields = {"height", "width"};
  s.other_fields = {"header", "fields", "data"};
  s.received = 100;
  s.full_bytes_per_sample = 6'291'725;
  s.payload_bytes_per_sample = 12;
  s.wire_bytes_per_sample = 82;
  s.learning_bytes = 0;
  s.latency_p50_us = 120.04;
  s.latency_p99_us = 310.5;
  return s;
}

SubscriberFigures viewer() {
  SubscriberFigures s = diagnostic();
  s.name = "viewer";
  s.host = "lidar";
  s.transport = "shm";
  s.reason = "same host";
  s.fields = {"header", "height", "width", "fields", "data"};
  s.other_fields = {};
  s.wire_bytes_per_sample = 0;
  return s;
}

RunFigures run_of(std::vector<SubscriberFigures> subscribers) {
  RunFigures run;
  run.input = "generated scene";
  run.message_shape = "128 x 1024 points";
  run.hz = 10;
  run.samples = 100;
  run.hosts = 4;
  run.idle_bytes_per_s = 135.2;
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

TEST(Measurement, OfControlTrafficIsARate) {
  const Traffic begin{.at_ns = 1'000'000'000, .control_sent = 500};
  const Traffic end{.at_ns = 9'000'000'000, .control_sent = 1540};
  EXPECT_EQ(control_bytes_per_s(begin, end), 130.0);
  EXPECT_EQ(control_bytes_per_s(begin, begin), 0.0);
}

TEST(Json, HasExactlyTheseKeysInThisOrder) {
  const nlohmann::ordered_json json = to_json(run_of({diagnostic()}));
  const std::vector<std::string> run_keys{"input", "samples", "hosts", "idle_bytes_per_s", "subscribers"};
  const std::vector<std::string> subscriber_keys{"name",
                                                 "transport",
                                                 "reason",
                                                 "fields",
                                                 "requirement",
                                                 "received",
                                                 "lost",
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
  const nlohmann::ordered_json json = to_json(run_of({diagnostic()}));
  EXPECT_EQ(json["input"], "generated scene");
  EXPECT_EQ(json["samples"], 100);
  EXPECT_EQ(json["hosts"], 4);
  EXPECT_EQ(json["idle_bytes_per_s"], 135.2);
  const auto& s = json["subscribers"][0];
  EXPECT_EQ(s["fields"], nlohmann::json({"height", "width"}));
  EXPECT_EQ(s["requirement"], "declared");
  EXPECT_EQ(s["wire_bytes_per_sample"], 82);
  EXPECT_EQ(s["latency_us"]["p50"], 120.0);
  EXPECT_EQ(s["latency_us"]["p99"], 310.5);
}

TEST(Json, HasNullForWhatWasNotMeasured) {
  SubscriberFigures s = diagnostic();
  s.wire_bytes_per_sample.reset();
  s.latency_p50_us.reset();
  RunFigures run = run_of({s});
  run.idle_bytes_per_s.reset();
  const nlohmann::ordered_json json = to_json(run);
  EXPECT_TRUE(json["idle_bytes_per_s"].is_null());
  EXPECT_TRUE(json["subscribers"][0]["wire_bytes_per_sample"].is_null());
  EXPECT_TRUE(json["subscribers"][0]["latency_us"]["p50"].is_null());
}

TEST(Text, HasUnitsThatPeopleRead) {
  EXPECT_EQ(format_bytes(0), "0 B");
  EXPECT_EQ(format_bytes(81.6), "82 B");
  EXPECT_EQ(format_bytes(1570), "1.57 kB");
  EXPECT_EQ(format_bytes(6'291'725), "6.29 MB");
  EXPECT_EQ(format_bytes(2.5e9), "2.50 GB");
  EXPECT_EQ(format_count(0), "0");
  EXPECT_EQ(format_count(999), "999");
  EXPECT_EQ(format_count(1000), "1,000");
  EXPECT_EQ(format_count(6'291'725), "6,291,725");
}

TEST(Text, NamesFieldsTheShorterWay) {
  SubscriberFigures s;
  EXPECT_EQ(format_fields(s), "none");
  s.fields = {"height", "width"};
  EXPECT_EQ(format_fields(s), "all");
  s.other_fields = {"header", "data", "fields"};
  EXPECT_EQ(format_fields(s), "height, width");
  s.other_fields = {"data"};
  EXPECT_EQ(format_fields(s), "all but data");
}

TEST(Table, HasALineForEachSubscriber) {
  const std::vector<std::string> table = format_table(run_of({diagnostic(), viewer()}));
  ASSERT_EQ(table.size(), 3U);
  EXPECT_THAT(table[1], AllOf(HasSubstr("diagnostic"), HasSubstr("82 B"), HasSubstr("99.9986 %"),
                              HasSubstr("another host")));
  EXPECT_THAT(table[2],
              AllOf(HasSubstr("viewer"), HasSubstr("shm"), HasSubstr("0 B"), HasSubstr("same host")));
}

TEST(Table, DoesNotPraiseSavingsThatAreNone) {
  SubscriberFigures s = diagnostic();
  s.wire_bytes_per_sample = 6'542'152;  // headers cost more than the fields left out
  EXPECT_THAT(format_table(run_of({s}))[1], AllOf(HasSubstr("nothing"), Not(HasSubstr("%"))));
}

TEST(Summary, TellsWhoGotWhatAndWhatItSaved) {
  EXPECT_THAT(
      format_summary(run_of({diagnostic(), viewer()})),
      AllOf(HasSubstr("published 100 point clouds (128 x 1024 points"),
            HasSubstr("82 B a sample crossed the network instead of 6.29 MB: 99.9986 % saved"),
            HasSubstr("shared memory"), HasSubstr("Nothing was lost."), HasSubstr("135 bytes/s per node")));
}

TEST(Summary, TellsWhoLostWhat) {
  SubscriberFigures s = diagnostic();
  s.lost = 3;
  s.incomplete = 1;
  EXPECT_THAT(format_summary(run_of({s})), HasSubstr("diagnostic lost 3 of 100 (1 came in part)"));
}

TEST(Summary, SaysPlainlyThatThereWereNoHosts) {
  SubscriberFigures s = diagnostic();
  s.wire_bytes_per_sample.reset();
  RunFigures run = run_of({s});
  run.hosts = 1;
  run.idle_bytes_per_s.reset();
  EXPECT_THAT(format_summary(run), AllOf(HasSubstr("over loopback"), HasSubstr("12 B a sample arrived *"),
                                         Not(HasSubstr("crossed the network"))));
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
