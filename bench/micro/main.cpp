// Times the operations of the data path alone, on one core, as ratios to copies of memory in the same run. A
// run can be kept, and a later one says what has changed since by more than the noise within both.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "bench/common/process.h"
#include "bench/common/program.h"
#include "bench/common/statistics.h"
#include "bench/micro/change.h"
#include "bench/micro/measurement.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::micro;

class Study {
 public:
  std::vector<Figure> measure(const Operations& operations) {
    std::vector<Figure> figures;
    for (const Measured& measured : micro::measure(operations, scale)) {
      const std::string name = "micro_" + measured.name;
      for (std::size_t i = 0; i < std::min(measured.ns.size(), measured.copy_ns.size()); ++i)
        ratios_[name].push_back(measured.ns[i] / measured.copy_ns[i]);
      figures.push_back({.name = name,
                         .value = median(measured.ns),
                         .unit = "ns",
                         .reference = median(measured.copy_ns),
                         .reference_name = fmt::format("memcpy of {} bytes", measured.copied_bytes),
                         .worst = std::ranges::max(measured.ns)});
    }
    return figures;
  }

  /// The error is empty if all is well. Opens the files.
  std::string open(const std::string& keep, const std::string& against) {
    if (!against.empty()) {
      std::ifstream file(against);
      before_ = read(file);
      if (before_.empty()) return against + " is no file that --keep has written";
    }
    if (!keep.empty()) kept_.open(keep);
    return kept_.fail() ? "cannot write " + keep : "";
  }

  void finish() {
    if (!before_.empty()) fmt::print("\n{}", text_of(compare(before_, ratios_)));
    if (kept_.is_open()) write(kept_, ratios_);
  }

  micro::Scale scale{};

 private:
  Ratios ratios_;
  Ratios before_;
  std::ofstream kept_;
};

void shorten(micro::Scale& scale) { scale = {.repetitions = 25, .repetition_s = 0.01}; }

}  // namespace

int main(int argc, char** argv) {
  Study study;
  Program program("Times of single operations of the data path, against copies of memory in the same run",
                  {{"encode", [&] { return study.measure(encode_operations()); }},
                   {"gather", [&] { return study.measure(gather_operations()); }},
                   {"view", [&] { return study.measure(view_operations()); }},
                   {"mask", [&] { return study.measure(mask_operations()); }},
                   {"fragment", [&] { return study.measure(fragment_operations()); }},
                   {"reassemble", [&] { return study.measure(reassemble_operations()); }},
                   {"negotiate", [&] { return study.measure(negotiate_operations()); }}});
  std::string keep, against;
  program.options().add_flag_callback(
      "--quick", [&] { shorten(study.scale); }, "fewer and shorter repetitions");
  program.options()
      .add_option("--repetitions", study.scale.repetitions, "repetitions of each operation, in random order")
      ->check(CLI::Range(8, 1000));
  program.options().add_option("--keep", keep, "keep this run in this file, as a baseline");
  program.options().add_option(
      "--against", against,
      "say what has changed since the run in this file, by more than the noise within both");
  if (const auto code = program.parse(argc, argv)) return *code;
  if (const std::string error = study.open(keep, against); !error.empty()) {
    fmt::print(stderr, "{}\n", error);
    return 1;
  }
  pin_to_core(1);
  const int code = program.run();
  study.finish();
  return code;
}
