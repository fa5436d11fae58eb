// Measures the single operations of the data path on one core, relative to copies of memory in the same run.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "bench/common/process.h"
#include "bench/common/program.h"
#include "bench/common/statistics.h"
#include "bench/micro/measurement.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::micro;

std::vector<Figure> figures_of(const Operations& operations, const micro::Scale& scale) {
  std::vector<Figure> figures;
  for (const Measured& measured : micro::measure(operations, scale)) {
    figures.push_back({.name = "micro_" + measured.name,
                       .value = median(measured.ns),
                       .unit = "ns",
                       .reference = median(measured.copy_ns),
                       .reference_name = fmt::format("memcpy of {} bytes", measured.copied_bytes),
                       .worst = std::ranges::max(measured.ns)});
  }
  return figures;
}

void shorten(micro::Scale& scale) { scale = {.repetitions = 25, .repetition_s = 0.01}; }

}  // namespace

int main(int argc, char** argv) {
  micro::Scale scale;
  Program program("Times of single operations of the data path, against copies of memory in the same run",
                  {{"encode", [&] { return figures_of(encode_operations(), scale); }},
                   {"gather", [&] { return figures_of(gather_operations(), scale); }},
                   {"view", [&] { return figures_of(view_operations(), scale); }},
                   {"mask", [&] { return figures_of(mask_operations(), scale); }},
                   {"fragment", [&] { return figures_of(fragment_operations(), scale); }},
                   {"reassemble", [&] { return figures_of(reassemble_operations(), scale); }},
                   {"negotiate", [&] { return figures_of(negotiate_operations(), scale); }}});
  program.options().add_flag_callback(
      "--quick", [&] { shorten(scale); }, "fewer and shorter repetitions");
  program.options()
      .add_option("--repetitions", scale.repetitions, "repetitions of each operation, in random order")
      ->check(CLI::Range(8, 1000));
  if (const auto code = program.parse(argc, argv)) return *code;
  pin_to_core(1);
  return program.run();
}
