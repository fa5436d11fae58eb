// These tests check what ./run bench peers does without a network: which entrants take part in which turns,
// and the evaluation of records.
#include <gmock/gmock.h>

#include <algorithm>
#include <sstream>

#include "bench/peers/entrant.h"
#include "bench/peers/figures.h"
#include "bench/peers/pace.h"
#include "bench/peers/tables.h"

namespace sft::bench::peers {

namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr Case asleep{Where::one_host, Waiting::sleeping}, awake{Where::one_host, Waiting::spinning};
constexpr Case remote{Where::two_hosts, Waiting::sleeping};
constexpr Entrant full{Way::sft_full}, iceoryx{Way::iceoryx}, tcp{Way::tcp}, copy{Way::memcpy_alone};
const std::vector<Column> column{{"16 B", asleep, 16}};

/// Returns the record of a round with `samples` latencies, all of them `us`.
Record record(const Entrant& entrant, double us, double per_s = 1000, std::size_t samples = 2000) {
  Record record{.group = "intra", .of = asleep, .entrant = entrant, .bytes = 16, .per_s = per_s, .lost = 0};
  set_latency(record, std::vector<double>(samples, us));
  return record;
}

TEST(Entrants, HaveASpinOf0OnlyWhereReadersSleep) {
  EXPECT_THAT(entrants(asleep), Contains(Entrant{Way::sft_full, true}));
  EXPECT_THAT(entrants(awake), Not(Contains(Entrant{Way::sft_full, true})));
}

TEST(Entrants, BetweenHostsShareNoMemory) {
  const std::vector<Entrant> all = entrants(remote);
  EXPECT_THAT(all, Contains(full));
  for (const Way way : {Way::iceoryx, Way::cyclone_iceoryx, Way::fast_dds_memory, Way::sft_loan})
    EXPECT_THAT(all, Not(Contains(Entrant{way})));
}

TEST(Entrants, WithoutReadersDoNotTakePartWhereReadersAreCounted) {
  EXPECT_THAT(entrants(asleep), Contains(copy));
  EXPECT_THAT(entrants({Where::one_host, Waiting::sleeping, 8}), Not(Contains(copy)));
}

TEST(Entrants, HaveDifferentIds) {
  std::vector<std::string> ids;
  for (const Entrant& entrant : entrants(asleep)) ids.push_back(id_of(entrant));
  std::ranges::sort(ids);
  EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end());
}

TEST(Turns, BeginWithAnotherEntrantInEachRound) {
  EXPECT_THAT(turns({full, tcp, copy}, 0), ElementsAre(full, tcp, copy));
  EXPECT_THAT(turns({full, tcp, copy}, 1), ElementsAre(tcp, copy, full));
  EXPECT_THAT(turns({full, tcp, copy}, 3), ElementsAre(full, tcp, copy));
  EXPECT_THAT(turns({}, 1), IsEmpty());
}

TEST(Pace, KeepsFewLargeSamples) {
  EXPECT_EQ(depth_of(16), 64U);
  EXPECT_EQ(depth_of(bytes_max), 4U);
}

TEST(Pace, TheScalesFitIntoTheBoard) {
  for (const Scale& scale : {Scale{}, quick_scale()}) {
    EXPECT_LE(scale.sizes.size(), sizes_max);
    EXPECT_LE(std::ranges::max(scale.readers), readers_max);
    EXPECT_LE(scale.pace.samples, samples_max);
    EXPECT_LE(std::ranges::max(scale.sizes), bytes_max);
  }
}

TEST(Latency, HasQuantilesByNearestRank) {
  std::vector<double> times;
  for (int i = 1000; i > 0; --i) times.push_back(i);
  Record record;
  set_latency(record, times);
  EXPECT_EQ(record.samples, 1000U);
  EXPECT_EQ(record.p50_us, 500);
  EXPECT_EQ(record.p90_us, 900);
  EXPECT_EQ(record.p99_us, 990);
  EXPECT_EQ(record.p999_us, 999);
}

TEST(Spread, IsTheMedianAndTheRangeOfTheRoundsThatDidNotFail) {
  const Spread all = spread(std::vector<double>{5, unknown, 1, 3});
  EXPECT_EQ(all.median, 3);
  EXPECT_EQ(all.least, 1);
  EXPECT_EQ(all.most, 5);
  EXPECT_FALSE(spread(std::vector<double>{unknown}).median == spread(std::vector<double>{unknown}).median);
}

TEST(Tables, WriteNumbersWithThreeDigitsThatCount) {
  EXPECT_EQ(number_text(0.1234), "0.12");
  EXPECT_EQ(number_text(9.994), "9.99");
  EXPECT_EQ(number_text(9.996), "10.0");
  EXPECT_EQ(number_text(99.96), "100");
  EXPECT_EQ(number_text(999.6), "1,000");
  EXPECT_EQ(number_text(1'234'007), "1,234,007");
  EXPECT_EQ(number_text(unknown), "-");
}

TEST(Tables, ShowMediansWithRanges) {
  const std::string text = tables({record(full, 10), record(full, 20), record(full, 30)}, "Title", column);
  EXPECT_THAT(text, AllOf(HasSubstr("Title"), HasSubstr("16 B"), HasSubstr("SFT, full"),
                          HasSubstr("20.0 (10.0 to 30.0)")));
  EXPECT_THAT(text, Not(HasSubstr("TCP"))) << "it has no record";
}

TEST(Tables, MarkTheWorstOfFewSamples) {
  EXPECT_THAT(tables({record(full, 10)}, "", column), Not(HasSubstr("10.0w")));
  EXPECT_THAT(tables({record(full, 10, 1000, 999)}, "", column), HasSubstr("10.0 / 10.0 / 10.0w"));
}

TEST(Tables, SayWhatWasLost) {
  Record lossy = record(full, 10);
  lossy.lost = 0.25;
  EXPECT_THAT(tables({lossy}, "", column), HasSubstr("lost 25.0 %"));
}

TEST(PeersFigures, HaveTheBestPeerAsReference) {
  const std::vector<Figure> all =
      figures("intra", {record(full, 20, 3000), record(tcp, 40, 9000), record(iceoryx, 10, 1000)}, column);
  const auto figure = [&](const std::string& name) {
    const auto found = std::ranges::find(all, name, &Figure::name);
    return found == all.end() ? Figure{"no " + name} : *found;
  };
  EXPECT_EQ(figure("intra_1_16B_sft_full_p50").reference, 10);
  EXPECT_EQ(figure("intra_1_16B_sft_full_p50").reference_name, "iceoryx, copied");
  EXPECT_EQ(figure("intra_1_16B_sft_full_rate").value, 3);
  EXPECT_EQ(figure("intra_1_16B_sft_full_rate").reference, 9);
}

TEST(PeersCsv, HasALineForEachRecord) {
  std::ostringstream out;
  write_csv(out, {record(full, 20), record(tcp, 40)});
  EXPECT_THAT(out.str(), AllOf(HasSubstr("\nintra,one_host,sleeping,1,sft_full,16,1,2000,20.00,"),
                               HasSubstr("\nintra,one_host,sleeping,1,tcp,16,1,2000,40.00,")));
}

}  // namespace

}  // namespace sft::bench::peers
