#include "bench/peers/pace.h"

#include <fmt/format.h>

#include <algorithm>

namespace sft::bench::peers {

namespace {

constexpr std::uint32_t KiB = 1024, MiB = 1024 * KiB;

}  // namespace

Scale quick_scale() {
  return {.rounds = 1,
          .sizes = {16, 16 * KiB, bytes_max},
          .pace = {.samples = 250, .samples_min = 5, .latency_s = 0.08, .throughput_s = 0.08},
          .readers = {1, 8},
          .sizes_of_readers = {16, MiB},
          .pace_of_readers = {.samples = 150, .samples_min = 5, .latency_s = 0.05, .throughput_s = 0.05}};
}

std::uint32_t depth_of(std::uint32_t bytes) { return std::clamp<std::uint32_t>(4 * MiB / bytes, 4, 64); }

std::string size_text(std::uint32_t bytes) {
  if (bytes >= MiB) return fmt::format("{} MiB", bytes / MiB);
  return bytes >= KiB ? fmt::format("{} KiB", bytes / KiB) : fmt::format("{} B", bytes);
}

}  // namespace sft::bench::peers
