// Measures whether a remote reader disturbs the readers on the publisher's host. A camera and a lidar send
// 6.3 MB at 20 Hz to three local readers. Meanwhile a remote reader joins, stalls, loses packets, requests
// all fields over a narrow link, and is killed. SFT, Cyclone DDS and Fast DDS run one after the other.
// Hosts are network namespaces with an MTU of 1500. The system chooses the cores.
#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/common/program.h"
#include "bench/common/statistics.h"
#include "bench/isolation/course.h"
#include "tests/support/isolated_host.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::isolation;

constexpr unsigned shm_mebibytes = 1024;  // enough for all of sftd's default memory, as on a usual robot

const std::map<std::string, Middleware> middleware_by_option{
    {"sft", Middleware::sft}, {"cyclone", Middleware::cyclone}, {"fast_dds", Middleware::fast_dds}};

class Study {
 public:
  std::vector<Figure> measure(bool reliable) {
    if (network_ == nullptr)
      network_ = std::make_shared<sft::hosts::EmulatedNetwork>(make_hosts(2, Trains::cut));
    for (int round = 0; round < scale.rounds; ++round) {
      for (const Middleware middleware : scale.middleware) {
        if (scale.quick && !reliable && middleware != Middleware::sft) continue;
        run_course({middleware, reliable}, network_, scale, results_);
      }
    }
    fmt::print("{}", legend());
    for (const Middleware middleware : all_middleware) {
      const isolation::Contender contender{middleware, reliable};
      if (results_.has(contender)) fmt::print("{}", table(results_, contender));
    }
    fmt::print("\n");
    std::fflush(stdout);  // otherwise each process that is forked later would have a copy of the output
    return figures(results_, reliable);
  }

  void finish() const {
    std::vector<double> late_us = results_.late_us();
    fmt::print("Publishers ran {:.0f} us (p50) and {:.0f} us (p99) later than planned.\n",
               quantile(late_us, 0.5), quantile(late_us, 0.99));
  }

  isolation::Scale scale{};

 private:
  std::shared_ptr<const sft::hosts::EmulatedNetwork> network_;
  Results results_;
};

void shorten(isolation::Scale& scale) {
  scale.quick = true;
  scale.rounds = 1;
  scale.phase_s = 1.7;
}

}  // namespace

int main(int argc, char** argv) {
  Study study;
  Program program("Whether a remote reader disturbs local ones, beside Cyclone DDS and Fast DDS",
                  {{"reliable", [&] { return study.measure(true); }},
                   {"best_effort", [&] { return study.measure(false); }}});
  program.options().add_flag_callback(
      "--quick", [&] { shorten(study.scale); }, "one short round, and best effort with SFT only");
  program.options()
      .add_option("--middleware", study.scale.middleware, "these contenders only")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(CLI::CheckedTransformer(middleware_by_option));
  program.options()
      .add_option("--rounds", study.scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 20));
  program.options()
      .add_option("--seconds", study.scale.phase_s, "the length of each phase")
      ->check(CLI::Range(0.5, 30.));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] {
    const sft::test::ShmOfSize memory(shm_mebibytes);
    const int code = program.run();
    study.finish();
    return code;
  });
}
