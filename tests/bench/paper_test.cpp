// These tests check what ./run bench paper does without a network: the fields that receivers draw, the
// times at which contenders write, and the evaluation of records.
#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "bench/paper/figures.h"
#include "bench/paper/record.h"
#include "bench/paper/schedule.h"
#include "bench/paper/tables.h"

namespace sft::bench::paper {

namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;

constexpr Configuration five_small{.fields = 5, .field_bytes = 128, .receivers = 3, .percent = 75};
constexpr Contender ours{Way::sft_recorded}, cyclone{Way::cyclone}, fast_dds{Way::fast_dds};

TEST(DrawnFields, AreTheSameForTheSameArguments) {
  for (std::size_t receiver = 0; receiver < 3; ++receiver)
    EXPECT_EQ(draw_fields(1, five_small, 2, receiver), draw_fields(1, five_small, 2, receiver));
  EXPECT_EQ(draw_fields(1, five_small, 0, 0), 0b10111U) << "on every machine";
}

TEST(DrawnFields, DifferBetweenSeedsRepeatsAndReceivers) {
  const auto drawn = [](std::uint64_t seed, std::size_t repeat, std::size_t receiver) {
    std::vector<FieldSet> all;
    for (std::size_t bytes = 1; bytes < 100; ++bytes)
      all.push_back(draw_fields(seed, {.fields = 7, .field_bytes = bytes, .percent = 50}, repeat, receiver));
    return all;
  };
  EXPECT_NE(drawn(1, 0, 0), drawn(2, 0, 0));
  EXPECT_NE(drawn(1, 0, 0), drawn(1, 1, 0));
  EXPECT_NE(drawn(1, 0, 0), drawn(1, 0, 1));
}

TEST(DrawnFields, AreRequiredWithTheProbability) {
  constexpr std::size_t draws = 4000;
  for (const int percent : {50, 75, 90, 100}) {
    int fields = 0;
    for (std::size_t repeat = 0; repeat < draws; ++repeat)
      fields += std::popcount(draw_fields(3, {.fields = 7, .percent = percent}, repeat, 0));
    EXPECT_NEAR(fields / (7. * draws), percent / 100., 0.01);
  }
}

TEST(DrawnFields, MayBeNoneAtAll) {
  std::vector<FieldSet> drawn;
  for (std::size_t repeat = 0; repeat < 500; ++repeat)
    drawn.push_back(draw_fields(1, {.fields = 5, .percent = 50}, repeat, 0));
  EXPECT_THAT(drawn, Contains(0U));
  EXPECT_THAT(drawn, Each(testing::Le(all_fields(5))));
}

TEST(LeastBytes, CountTheHeadersOfEachFrame) {
  EXPECT_EQ(least_bytes(0), 42);
  EXPECT_EQ(least_bytes(1472), 1514);
  EXPECT_EQ(least_bytes(1473), 1473 + 2 * 42);
}

TEST(Schedule, GivesEachContenderATurnOfItsOwn) {
  const Schedule schedule({.rate_hz = 25, .learning = 0, .settled_s = 0, .settling = 2, .samples = 3}, 4,
                          1000);
  constexpr std::int64_t period_ns = 40'000'000;
  EXPECT_EQ(schedule.due_ns(0, 0, 0), 1000);
  EXPECT_EQ(schedule.due_ns(0, 0, 3) - schedule.due_ns(0, 0, 2), period_ns / 4);
  EXPECT_EQ(schedule.due_ns(0, 1, 0) - schedule.due_ns(0, 0, 3), period_ns / 4);
}

TEST(Schedule, CountsFromBeforeTheFirstMessageUntilAfterTheLast) {
  const Schedule schedule({.rate_hz = 25, .learning = 0, .settled_s = 0, .settling = 2, .samples = 3}, 4,
                          1000);
  EXPECT_GT(schedule.before_ns(0), schedule.due_ns(0, 1, 3));
  EXPECT_LT(schedule.before_ns(0), schedule.due_ns(0, 2, 0));
  EXPECT_GT(schedule.after_ns(0), schedule.due_ns(0, 4, 3));
  EXPECT_LT(schedule.after_ns(0), schedule.due_ns(1, 0, 0));
}

TEST(Schedule, RefusesARateAtWhichTurnsAreTooShort) {
  EXPECT_EQ(check({.rate_hz = 50}, 20), "");
  EXPECT_EQ(check({.rate_hz = 60}, 20), "20 contenders take turns: the rate may be 50 Hz at most");
}

/// Returns a record of one receiver, which got `bytes` although `cdr_bytes` would have sufficed.
Record record(const Contender& contender, double bytes, double p50_us, const Case& of,
              double cdr_bytes = 2000, double lost = 0) {
  const Received receiver{
      .fields = 3, .cdr_bytes = cdr_bytes, .least_bytes = cdr_bytes, .bytes = bytes, .lost = lost};
  return {.of = of,
          .contender = contender,
          .receivers = {receiver},
          .sender_bytes = bytes,
          .p50_us = p50_us,
          .cpu_us = 100,
          .resident_bytes = 1e6};
}

Case parametric(int percent, std::size_t repeat) {
  return {"parametric", {.fields = 5, .field_bytes = 512, .receivers = 1, .percent = percent}, repeat};
}

Figure figure(const std::vector<Figure>& figures, const std::string& name) {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  return found == figures.end() ? Figure{"no " + name} : *found;
}

TEST(Comparison, TakesCasesThatBothHaveMeasured) {
  const Records all{record(ours, 100, 1, parametric(50, 0)), record(ours, 900, 1, parametric(50, 1)),
                    record(cyclone, 200, 1, parametric(50, 0)), record(cyclone, 700, 1, parametric(75, 0))};
  const Means both = means(
      all, ours, cyclone, [](const Case&) { return true; }, received_bytes);
  EXPECT_EQ(both.ours, 100);
  EXPECT_EQ(both.theirs, 200);
}

TEST(Comparison, LeavesOutRecordsWithLosses) {
  const Records all{record(ours, 100, 1, parametric(50, 0), 80, 0.04),
                    record(ours, 20, 1, parametric(50, 1), 80, 0.5)};
  EXPECT_EQ(records_of(all, ours, [](const Case&) { return true; }).size(), 1U);
}

TEST(Comparison, LeavesOutDisturbedRecords) {
  Record disturbed = record(ours, 900, 1, parametric(50, 1));
  disturbed.disturbed = true;
  const Records all{record(ours, 100, 1, parametric(50, 0)), disturbed};
  EXPECT_EQ(records_of(all, ours, [](const Case&) { return true; }).size(), 1U);
}

TEST(Comparison, NamesConfigurationsInTheirOrder) {
  const Records all{record(ours, 1, 1, parametric(75, 0)), record(ours, 1, 1, parametric(50, 0)),
                    record(ours, 1, 1, parametric(50, 1)), record(ours, 1, 1, {"battery", {.receivers = 1}})};
  EXPECT_THAT(labels(all),
              ElementsAre("battery", "5 x 512 B, 1 receiver, 50 %", "5 x 512 B, 1 receiver, 75 %"));
}

TEST(Figures, CompareBytesWithThePeersFullMessages) {
  const Records all{record(ours, 100, 1, parametric(50, 0)), record(cyclone, 210, 1, parametric(50, 0)),
                    record(fast_dds, 190, 1, parametric(50, 0))};
  const auto figures = row_figures(all, parametric_rows());
  EXPECT_NEAR(figure(figures, "bandwidth_50").measure(), 100 / 210., 1e-9);
  EXPECT_TRUE(figure(figures, "bandwidth_50").within_bound());
  EXPECT_FALSE(figure(figures, "bandwidth_50_vs_fast_dds").within_bound());
  EXPECT_EQ(figure(figures, "bandwidth_75").name, "no bandwidth_75") << "there are no records of it";
}

TEST(Figures, CompareLatencyWithTheBetterPeer) {
  const Records all{record(ours, 1, 100, parametric(50, 0)), record(cyclone, 1, 120, parametric(50, 0)),
                    record(fast_dds, 1, 90, parametric(50, 0))};
  const Figure latency = figure(row_figures(all, parametric_rows()), "latency_50");
  EXPECT_EQ(latency.reference, 90);
  EXPECT_FALSE(latency.within_bound());
}

TEST(Figures, HaveNoBoundBesideAPeerThatLostItsMessages) {
  const Records all{record(ours, 100, 100, parametric(50, 0)), record(cyclone, 200, 120, parametric(50, 0)),
                    record(fast_dds, 20, 90, parametric(50, 0), 2000, 0.5)};
  const auto figures = row_figures(all, parametric_rows());
  EXPECT_FALSE(figure(figures, "bandwidth_50_vs_fast_dds").bound);
  EXPECT_TRUE(figure(figures, "bandwidth_50").bound);
  EXPECT_EQ(figure(figures, "latency_50").reference, 120);
}

TEST(Figures, TellTheWorstConfiguration) {
  const Records all{record(ours, 2100, 100, parametric(50, 0)), record(cyclone, 1, 200, parametric(50, 0)),
                    record(ours, 2020, 100, parametric(75, 0)), record(cyclone, 1, 110, parametric(75, 0)),
                    record(ours, 535, 50, parametric(90, 0), 500)};
  const auto figures = configuration_figures(all);
  EXPECT_THAT(figure(figures, "latency_worst"),
              Field(&Figure::reference_name, "Cyclone DDS, 5 x 512 B, 1 receiver, 75 %"));
  EXPECT_NEAR(figure(figures, "lower_bound_over_1kB").measure(), 1.05, 1e-9);
  EXPECT_EQ(figure(figures, "lower_bound_excess_to_1kB").value, 35);
}

TEST(Figures, ComparesSelectingWithSendingAllFields) {
  Record full = record({Way::sft_full}, 1, 1, parametric(50, 0));
  full.cpu_us = 50;
  const Records all{record(ours, 1, 1, parametric(50, 0)), full};
  EXPECT_EQ(figure(overhead_figures(all), "overhead_cpu").measure(), 2);
  EXPECT_EQ(figure(overhead_figures(all), "overhead_memory").measure(), 1);
  EXPECT_TRUE(overhead_figures({record(ours, 1, 1, {"battery", {.receivers = 1}})}).empty());
}

TEST(Tables, ShowThePapersResultsBesideThoseOfTheRun) {
  const Records all{record(ours, 1250, 100, parametric(50, 0)),
                    record(cyclone, 2500, 120, parametric(50, 0))};
  EXPECT_THAT(paper_table(all, parametric_rows()), AllOf(HasSubstr("269.7"), HasSubstr("-49.1 %"),
                                                         HasSubstr("200.0"), HasSubstr("100.0 (-50.0 %)")));
  EXPECT_THAT(draws_text(all), HasSubstr("requirement probability 50 %: 40.0 %, 0 without any"));
}

}  // namespace

}  // namespace sft::bench::paper
