// Repeats the experiments of the paper "Selective Field Transmission". Cyclone DDS and Fast DDS run in the
// same seconds. Hosts are network namespaces with an MTU of 1500. The system chooses the cores.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "bench/common/program.h"
#include "bench/common/statistics.h"
#include "bench/paper/experiments.h"
#include "bench/paper/figures.h"
#include "bench/paper/tables.h"
#include "tests/support/isolated_host.h"
#include "tests/support/recorded_data.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::paper;

/// Prints and flushes. Otherwise each process that is forked later would have a copy of the unwritten text.
void say(const std::string& text) {
  fmt::print("{}", text);
  std::fflush(stdout);
}

class Experiments {
 public:
  std::vector<Figure> parametric() {
    run_parametric_study(stage(), scale, results_);
    say(draws_text(results_.records));
    print(parametric_rows());
    return row_figures(results_.records, parametric_rows());
  }
  std::vector<Figure> nav2() {
    run_nav2_cases(stage(), scale, results_);
    print(nav2_rows());
    return row_figures(results_.records, nav2_rows());
  }
  std::vector<Figure> point_cloud() {
    run_point_cloud_case(stage(), scale, results_);
    print(point_cloud_rows());
    return row_figures(results_.records, point_cloud_rows());
  }
  /// Returns figures over all cases that the previous groups have measured.
  std::vector<Figure> bounds() const {
    std::vector<Figure> figures = configuration_figures(results_.records);
    if (figures.empty()) return {};
    for (Figure& figure : overhead_figures(results_.records)) figures.push_back(std::move(figure));
    return figures;
  }
  void finish() {
    auto& late_us = results_.late_us;
    fmt::print(
        "Writers ran {:.0f} us (p50) and {:.0f} us (p99) later than planned. {} of {} records "
        "do not count, since the machine stopped for long.\n",
        quantile(late_us, 0.5), quantile(late_us, 0.99),
        std::ranges::count_if(results_.records, &Record::disturbed), results_.records.size());
  }

  paper::Scale scale{};

 private:
  const Stage& stage() {
    if (stage_ == nullptr) {
      fmt::print(
          "Rate: {:.0f} Hz for each contender, in turns (the paper's is 10 Hz: --rate 10). Seed: {}.\n",
          scale.pace.rate_hz, scale.seed);
      stage_ = std::make_unique<Stage>(all_contenders());
    }
    return *stage_;
  }
  void print(const std::vector<Row>& rows) const { say(paper_table(results_.records, rows)); }

  std::unique_ptr<Stage> stage_;
  Results results_;
};

void shorten(Experiments& experiments) {
  experiments.scale.repeats = 1;
  experiments.scale.fields = {5};
  experiments.scale.field_bytes = {128, 512};
  experiments.scale.pace = {.samples = 20};
}

void add_options(CLI::App& to, Experiments& experiments) {
  Pace& pace = experiments.scale.pace;
  to.add_flag_callback(
      "--quick", [&] { shorten(experiments); }, "one short repeat of fewer configurations");
  to.add_option("--rate", pace.rate_hz, "messages a second of each contender")->check(CLI::Range(1., 1000.));
  to.add_option("--samples", pace.samples, "messages that count, in each case and repeat")
      ->check(CLI::Range(std::size_t{5}, samples_max));
  to.add_option("--repeats", experiments.scale.repeats, "repeats of each case, with other fields")
      ->check(CLI::Range(1, 100));
  to.add_option("--seed", experiments.scale.seed, "which fields receivers require");
  to.add_option("--data", experiments.scale.data, "the directory of recorded messages");
}

}  // namespace

int main(int argc, char** argv) {
  Experiments experiments;
  experiments.scale.data = sft::test::recorded_data();
  Program program("The experiments of the paper, beside Cyclone DDS and Fast DDS in the same seconds",
                  {{"parametric", [&] { return experiments.parametric(); }},
                   {"nav2", [&] { return experiments.nav2(); }},
                   {"pointcloud2", [&] { return experiments.point_cloud(); }},
                   {"bounds", [&] { return experiments.bounds(); }}});
  add_options(program.options(), experiments);
  if (const auto code = program.parse(argc, argv)) return *code;
  if (const std::string error = check(experiments.scale.pace, all_contenders().size()); !error.empty()) {
    fmt::print(stderr, "{}\n", error);
    return 1;
  }
  return sft::test::run_isolated([&] {
    const int code = program.run();
    experiments.finish();
    return code;
  });
}
