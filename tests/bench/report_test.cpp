// These tests check what benchmarks print and write, and how ./run bench many evaluates its rounds.
#include "bench/common/report.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/common/program.h"
#include "bench/many/settling.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

template <class Print>
std::string printed(Print print) {
  testing::internal::CaptureStdout();
  print();
  return testing::internal::GetCapturedStdout();
}

std::string missed(const std::vector<Figure>& figures) {
  return printed([&] { print_missed_bounds(figures); });
}

TEST(BenchReport, NamesTheBoundsThatDoNotHold) {
  const Figure good{.name = "good", .value = 2, .reference = 2, .bound = 1};
  const Figure slow{.name = "slow", .value = 3, .reference = 2, .bound = 1};
  const Figure failed{.name = "failed", .value = std::numeric_limits<double>::quiet_NaN(), .bound = 1};
  EXPECT_EQ(missed({good, slow, failed}), "These bounds do not hold: slow, failed.\n");
  EXPECT_EQ(missed({good}), "All bounds hold.\n");
  EXPECT_EQ(missed({{.name = "unbounded", .value = 1}}), "");
}

TEST(BenchReport, ATableHasAColumnForWorstRoundsIfThereAreAny) {
  const Figure plain{.name = "plain", .value = 2};
  const Figure worst{.name = "tallied", .value = 2, .worst = 7.5};
  EXPECT_THAT(printed([&] { print_table({plain}); }), Not(HasSubstr("worst")));
  EXPECT_THAT(printed([&] {
                print_table({plain, worst});
              }),
              AllOf(HasSubstr("worst round\n"), HasSubstr("7.500\n")));
}

TEST(BenchReport, JsonHasTheFieldsOfEachFigure) {
  std::ostringstream out;
  write_json(out, {{.name = "time", .value = 3, .unit = "us", .reference = 2}, {.name = "lost", .value = 0}});
  const auto json = nlohmann::json::parse(out.str());
  EXPECT_EQ(json[0], nlohmann::json::parse(
                         R"({"name": "time", "value": 3, "unit": "us", "reference": 2, "ratio": 1.5})"));
  EXPECT_EQ(json[1], nlohmann::json::parse(
                         R"({"name": "lost", "value": 0, "unit": "", "reference": null, "ratio": null})"));
}

TEST(BenchReport, JsonHasBoundsAndWorstRoundsWhereTheyExist) {
  std::ostringstream out;
  write_json(out, {{.name = "time", .value = 3, .reference = 2, .bound = 2.5, .worst = 4},
                   {.name = "rate", .value = 3, .bound = 1, .at_least = true},
                   {.name = "idle", .value = 3, .reference = 2, .bound = 5, .bound_is_of_value = true}});
  const auto json = nlohmann::json::parse(out.str());
  const auto expect = [&](std::size_t number, const char* text) {
    EXPECT_EQ(json[number], nlohmann::json::parse(text));
  };
  expect(0, R"({"name": "time", "value": 3, "unit": "", "reference": 2, "ratio": 1.5, "bound": 2.5,
                "bound_of": "ratio", "worst": 4})");
  expect(1, R"({"name": "rate", "value": 3, "unit": "", "reference": null, "ratio": null, "bound": 1,
                "bound_of": "value", "at_least": true})");
  expect(2, R"({"name": "idle", "value": 3, "unit": "", "reference": 2, "ratio": 1.5, "bound": 5,
                "bound_of": "value"})");
}

/// Returns the names of the figures that a program with two groups prints with --only.
std::vector<std::string> chosen(std::string only) {
  std::vector<std::string> measured;
  const auto measure = [&](const std::string& name) {
    measured.push_back(name);
    return Figure{.name = name};
  };
  Program program("", {{"one", [&] { return std::vector{measure("one")}; }},
                       {"two", [&] {
                          return std::vector{measure("left"), measure("right")};
                        }}});
  std::array words{std::string("bench"), std::string("--only"), std::move(only)};
  std::array arguments{words[0].data(), words[1].data(), words[2].data()};
  EXPECT_FALSE(program.parse(3, arguments.data()));
  const std::string table = printed([&] { program.run(); });
  std::erase_if(measured,
                [&](const std::string& name) { return table.find("\n" + name) == std::string::npos; });
  return measured;
}

TEST(BenchProgram, TakesSeveralNamesOfGroups) {
  EXPECT_THAT(chosen("one"), ElementsAre("one"));
  EXPECT_THAT(chosen("two"), ElementsAre("left", "right"));
  EXPECT_THAT(chosen("two,one"), ElementsAre("one", "left", "right"));
}

TEST(BenchProgram, TellsHowNoisyTheMachineWas) {
  const std::string file = testing::TempDir() + "noise_" + std::to_string(getpid()) + ".json";
  Program program("", {{"one", [] { return std::vector{Figure{.name = "one", .value = 1}}; }}});
  std::array words{std::string("bench"), std::string("--json"), file};
  std::array arguments{words[0].data(), words[1].data(), words[2].data()};
  ASSERT_FALSE(program.parse(3, arguments.data()));
  EXPECT_THAT(printed([&] { EXPECT_EQ(program.run(), 0); }), HasSubstr("\nNoise: beside the "));
  std::ifstream in(file);
  std::vector<std::string> names;
  for (const auto& figure : nlohmann::json::parse(in)) {
    names.push_back(figure["name"]);
    EXPECT_TRUE(figure["value"].is_number());  // a NaN would be written as null
  }
  EXPECT_THAT(names, ElementsAre("one", "noise_other_programs", "noise_other_machines"));
  std::filesystem::remove(file);
}

TEST(BenchTally, HasMediansAndTheWorstRound) {
  Tally tally;
  for (const double value : {3., 9., 4.}) tally.add_ours(value);
  for (const double value : {2., 1., 6.}) tally.add_reference(value);
  const Figure most = tally.figure("time", "us", "other", 1.5);
  EXPECT_EQ(most.value, 4);
  EXPECT_EQ(most.reference, 2);
  EXPECT_EQ(most.worst, 9);
  EXPECT_FALSE(most.within_bound());
  const Figure least = tally.figure("rate", "GB/s", "other", 1.5, true);
  EXPECT_EQ(least.worst, 3);
  EXPECT_TRUE(least.within_bound());
}

TEST(BenchTally, DoesNotCountARoundThatFailed) {
  Tally tally;
  tally.add_ours(std::numeric_limits<double>::quiet_NaN());
  tally.add_ours(5);
  EXPECT_EQ(tally.figure("time", "us", "other", 1).value, 5);
}

TEST(BenchTally, WithoutRoundsIsWithinNoBound) {
  EXPECT_FALSE(Tally().figure("time", "us", "other", 1).within_bound());
  EXPECT_FALSE(Tally().figure_with_bound_of_value("time", "us", "other", 1).within_bound());
}

/// Returns samples every 10 ms, the first at 0, with these numbers of bytes.
std::vector<Counted> samples(const std::vector<std::int64_t>& bytes) {
  std::vector<Counted> counted;
  std::int64_t sum = 0;
  for (const std::int64_t of_sample : bytes) {
    counted.push_back({static_cast<std::int64_t>(counted.size()) * 10'000'000, sum});
    sum += of_sample;
  }
  return counted;
}

TEST(BenchSettling, IsTheTimeFromWhichOnBytesStayWithinFivePercent) {
  std::vector<std::int64_t> bytes(100, 1000);
  EXPECT_EQ(settled_ms(samples(bytes), 0), 0);
  for (int i = 0; i < 20; ++i) bytes[i] = 5000;
  EXPECT_EQ(settled_ms(samples(bytes), 0), 200);
  EXPECT_EQ(settled_ms(samples(bytes), 150'000'000), 50);
  EXPECT_EQ(settled_ms(samples(bytes), 300'000'000), 0);  // the bytes had settled before
  bytes[30] = 1200;                                       // 4 % of a window
  EXPECT_EQ(settled_ms(samples(bytes), 0), 200);
  bytes[30] = 1300;
  EXPECT_EQ(settled_ms(samples(bytes), 0), 310);
}

TEST(BenchSettling, IsNoNumberWithFewSamples) { EXPECT_TRUE(std::isnan(settled_ms(samples({1, 1, 1}), 0))); }

}  // namespace

}  // namespace sft::bench
