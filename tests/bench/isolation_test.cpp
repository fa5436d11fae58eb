// These tests check what ./run bench isolation does without a network: the turns that a publisher takes,
// and the evaluation of its notes.
#include <gmock/gmock.h>

#include <cmath>
#include <memory>

#include "bench/isolation/results.h"

namespace sft::bench::isolation {

namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr Contender ours{Middleware::sft, true}, cyclone{Middleware::cyclone, true};
constexpr std::int64_t us = 1000;

/// The notes of a publisher. The test says how long each message took to the local readers.
class Notes {
 public:
  void message(std::uint64_t number, std::int64_t publish_us, std::int64_t local_us) {
    board_->due_ns[number] = at(number);
    board_->sent_ns[number] = at(number) + 3 * us;
    board_->returned_ns[number] = board_->sent_ns[number] + publish_us * us;
    board_->page_faults[number] = 2;
    for (std::size_t reader = 0; reader < local_readers; ++reader)
      board_->arrived_ns[reader][number] = board_->sent_ns[number] + local_us * us;
  }
  void loses(std::size_t reader, std::uint64_t number) { board_->arrived_ns[reader][number] = 0; }
  void does_not_return(std::uint64_t number) { board_->returned_ns[number] = 0; }
  void reaches_remote(std::uint64_t number) { board_->arrived_ns[remote_reader][number] = at(number + 9); }

  Observation seen(std::uint64_t first, std::uint64_t end) const {
    return observe(*board_, {first, end}, {.s = 2, .local_cpu_s = 0.5, .remote_cpu_s = 0.1});
  }

 private:
  static std::int64_t at(std::uint64_t number) { return static_cast<std::int64_t>(number) * 50'000 * us; }

  const std::unique_ptr<Board> board_ = std::make_unique<Board>();
};

TEST(IsolationObservation, HasTheMessagesOfItsPhaseOnly) {
  Notes notes;
  for (std::uint64_t n = 1; n <= 6; ++n) notes.message(n, 10 * static_cast<std::int64_t>(n), 100);
  const Observation seen = notes.seen(3, 5);
  EXPECT_THAT(seen.publish_us, ElementsAre(30, 40));
  EXPECT_THAT(seen.late_us, ElementsAre(3, 3));
  EXPECT_EQ(seen.local_us.size(), 2 * local_readers);
}

TEST(IsolationObservation, CountsWhatReadersDidNotGet) {
  Notes notes;
  notes.message(1, 10, 100);
  notes.message(2, 10, 100);
  notes.loses(0, 1);
  notes.loses(2, 1);
  notes.reaches_remote(2);
  const Observation seen = notes.seen(1, 3);
  EXPECT_EQ(seen.lost, 2U);
  EXPECT_THAT(seen.local_us, ElementsAre(100, 100, 100, 100));
  EXPECT_EQ(seen.remote_received, 1U);
}

TEST(IsolationObservation, LeavesOutACallThatHasNotReturned) {
  Notes notes;
  notes.message(1, 10, 100);
  notes.does_not_return(1);
  EXPECT_THAT(notes.seen(1, 2).publish_us, IsEmpty());
}

TEST(IsolationTimes, AreMediansOverTheRoundsAndTheWorstOfAll) {
  const Times times = times_over({{1, 2, 9}, {}, {4, 5, 6}, {7, 8, 100}});
  EXPECT_EQ(times.p50, 5);
  EXPECT_EQ(times.p99, 9);
  EXPECT_EQ(times.worst, 100);
  EXPECT_EQ(times.p99_of_worst_round, 100);
}

TEST(IsolationTimes, AreNotANumberIfNothingArrived) { EXPECT_TRUE(std::isnan(times_over({{}, {}}).p99)); }

TEST(IsolationSummary, IsOfAllRounds) {
  Notes notes;
  for (std::uint64_t n = 1; n <= 3; ++n) notes.message(n, 10, 100);
  const Summary summary = summarize({notes.seen(1, 3), notes.seen(3, 4)});
  EXPECT_DOUBLE_EQ(summary.published_hz, 3 / 4.);
  EXPECT_DOUBLE_EQ(summary.cpu_percent, 25);
  EXPECT_DOUBLE_EQ(summary.remote_cpu_percent, 5);
  EXPECT_EQ(summary.page_faults, 6);
}

TEST(IsolationTurns, ComeInTheirPeriod) { EXPECT_EQ(next_turn_ns(100, 120, 50), 150); }

TEST(IsolationTurns, AreLeftOutAfterAHold) {
  EXPECT_EQ(next_turn_ns(100, 150, 50), 200);
  EXPECT_EQ(next_turn_ns(100, 290, 50), 300);
}

/// Returns results in which all phases take the same time, except for one.
Results results_with(const Contender& contender, Phase slow_phase, std::int64_t slow_us) {
  Results results;
  for (const Phase phase : all_phases) {
    Notes notes;
    notes.message(1, 20, phase == slow_phase ? slow_us : 100);
    results.add(contender, phase, notes.seen(1, 2));
  }
  return results;
}

auto figure(const char* name, double value, double reference) {
  return AllOf(Field(&Figure::name, name), Field(&Figure::value, value),
               Field(&Figure::reference, std::optional(reference)));
}

bool is_within_bounds(const std::vector<Figure>& figures, const std::string& name) {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  return found != figures.end() && found->bound && found->within_bound();
}

TEST(IsolationFigures, CompareEachDisturbanceWithTheBaseline) {
  const auto all = figures(results_with(ours, Phase::stalled, 300), true);
  EXPECT_THAT(all, Contains(figure("isolation_stalled_local_p99", 300, 100)));
  EXPECT_THAT(all, Contains(figure("isolation_stalled_publish_p99", 20, 20)));
  EXPECT_THAT(all, Contains(figure("isolation_again_local_p99", 100, 100)));
}

TEST(IsolationFigures, AreBoundForTheLocalReadersOfSft) {
  const auto all = figures(results_with(ours, Phase::stalled, 111), true);
  EXPECT_FALSE(is_within_bounds(all, "isolation_stalled_local_p99"));
  EXPECT_TRUE(is_within_bounds(all, "isolation_lossy_local_p99"));
}

TEST(IsolationFigures, OfOthersHaveNoBound) {
  for (const Figure& figure : figures(results_with(cyclone, Phase::stalled, 300), true))
    EXPECT_FALSE(figure.bound) << figure.name;
}

TEST(IsolationFigures, AreOfOneDelivery) {
  EXPECT_THAT(figures(results_with(ours, Phase::lossy, 300), false), IsEmpty());
  const Contender best_effort{Middleware::sft, false};
  EXPECT_THAT(figures(results_with(best_effort, Phase::lossy, 300), false),
              Contains(figure("isolation_best_effort_lossy_local_p99", 300, 100)));
}

TEST(IsolationTable, SaysByHowMuchAPhaseIsSlower) {
  const std::string text = table(results_with(ours, Phase::narrow, 250), ours);
  EXPECT_THAT(text, HasSubstr("SFT, reliable"));
  EXPECT_THAT(text, HasSubstr("0.25 (2.50)"));
}

TEST(IsolationTable, SaysWhereNothingArrived) {
  Results results = results_with(ours, Phase::narrow, 250);
  EXPECT_THAT(table(results, ours), Not(HasSubstr("none")));
  results = {};
  for (const Phase phase : all_phases) results.add(ours, phase, Notes().seen(1, 1));
  EXPECT_THAT(table(results, ours), HasSubstr("none"));
}

}  // namespace

}  // namespace sft::bench::isolation
