#include "bench/paper/experiments.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <string>
#include <utility>

namespace sft::bench::paper {

namespace {

constexpr int percents[] = {50, 75, 90, 100};
constexpr std::size_t receiver_counts[] = {1, receivers_max};

void print_step(const Scale& scale, std::size_t repeat, const std::string& what) {
  fmt::print(stderr, "  repeat {} of {}: {}\n", repeat + 1, scale.repeats, what);
}

/// Returns a seed for the order of the contenders, which is different in each session.
std::uint64_t next_seed(const Scale& scale, const Results& results) {
  return scale.seed * 1'000'003 + results.records.size();
}

Phase parametric_phase(const Configuration& of, std::size_t repeat, const Scale& scale) {
  Phase phase{.of = {"parametric", of, repeat}, .messages = parametric_messages(of.fields, of.field_bytes)};
  for (std::size_t r = 0; r < of.receivers; ++r) phase.needed[r] = draw_fields(scale.seed, of, repeat, r);
  return phase;
}

void run_parametric_session(const Stage& stage, Configuration of, std::size_t repeat, const Scale& scale,
                            Results& results) {
  print_step(scale, repeat,
             fmt::format("{} fields of {} B, {} receivers", of.fields, of.field_bytes, of.receivers));
  std::vector<Phase> phases;
  for (const int percent : percents) {
    of.percent = percent;
    phases.push_back(parametric_phase(of, repeat, scale));
  }
  // The order is random, since nodes have more idle traffic while they are young.
  std::shuffle(phases.begin(), phases.end(), std::mt19937_64(next_seed(scale, results)));
  run_session(stage, of.receivers, phases, scale.pace, next_seed(scale, results), results);
}

/// Adds a case if its messages are available on this machine.
void add(std::vector<Phase>& to, const char* name, std::size_t repeat, const SharedMessages& messages,
         const std::vector<FieldSet>& needed) {
  if (messages == nullptr) return;
  Phase phase{.of = {name, {.receivers = needed.size()}, repeat}, .messages = messages};
  std::copy(needed.begin(), needed.end(), phase.needed.begin());
  to.push_back(std::move(phase));
}

FieldSet all_but(const Messages& messages, const char* name) {
  return messages.all() & ~messages.named({name});
}

void add_scan(std::vector<Phase>& to, const char* name, std::size_t repeat, const SharedMessages& scans) {
  if (scans != nullptr) add(to, name, repeat, scans, {all_but(*scans, "intensities")});
}

void add_battery(std::vector<Phase>& to, const char* name, std::size_t repeat, const SharedMessages& states) {
  if (states != nullptr) add(to, name, repeat, states, {states->named({"current"})});
}

void add_grid(std::vector<Phase>& to, const char* name, std::size_t repeat, const SharedMessages& grids) {
  if (grids != nullptr) add(to, name, repeat, grids, {grids->all()});
}

/// Adds a case with three receivers: a diagnosis, an object detector and a SLAM.
void add_cloud(std::vector<Phase>& to, const char* name, std::size_t repeat, const SharedMessages& clouds) {
  if (clouds == nullptr) return;
  add(to, name, repeat, clouds,
      {clouds->named({"height", "width"}), clouds->named({"data"}), all_but(*clouds, "height")});
}

}  // namespace

void run_parametric_study(const Stage& stage, const Scale& scale, Results& results) {
  for (std::size_t repeat = 0; repeat < scale.repeats; ++repeat) {
    for (const std::size_t receivers : receiver_counts) {
      for (const std::size_t fields : scale.fields) {
        for (const std::size_t bytes : scale.field_bytes) {
          const Configuration of{.fields = fields, .field_bytes = bytes, .receivers = receivers};
          run_parametric_session(stage, of, repeat, scale, results);
        }
      }
    }
  }
}

void run_nav2_cases(const Stage& stage, const Scale& scale, Results& results) {
  for (std::size_t repeat = 0; repeat < scale.repeats; ++repeat) {
    print_step(scale, repeat, "Nav2");
    std::vector<Phase> phases;
    add_scan(phases, "laserscan", repeat, laser_scans());
    add_battery(phases, "battery", repeat, battery_states());
    add_grid(phases, "occupancygrid", repeat, occupancy_grids());
    add_scan(phases, "recorded_laserscan", repeat, recorded_laser_scans(scale.data));
    add_battery(phases, "recorded_battery", repeat, recorded_battery_states(scale.data));
    add_grid(phases, "recorded_occupancygrid", repeat, recorded_occupancy_grids(scale.data));
    run_session(stage, 1, phases, scale.pace, next_seed(scale, results), results);
  }
}

void run_point_cloud_case(const Stage& stage, const Scale& scale, Results& results) {
  for (std::size_t repeat = 0; repeat < scale.repeats; ++repeat) {
    print_step(scale, repeat, "PointCloud2");
    std::vector<Phase> phases;
    add_cloud(phases, "pointcloud2_aggregate", repeat, point_clouds());
    add_cloud(phases, "recorded_pointcloud2_aggregate", repeat, recorded_point_clouds(scale.data));
    run_session(stage, receivers_max, phases, scale.pace, next_seed(scale, results), results);
  }
}

}  // namespace sft::bench::paper
