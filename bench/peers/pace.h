// How many messages of each size are sent, and when.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sft::bench::peers {

inline constexpr std::uint32_t bytes_max = 8 << 20;
inline constexpr std::size_t sizes_max = 8;
inline constexpr std::size_t readers_max = 8;
inline constexpr std::size_t samples_max = 4096;  ///< of one size, whose latency is measured

struct Pace {
  std::int64_t period_us = 200;  ///< from a message to the next one; longer, until it has arrived
  std::size_t warm_up = 30;      ///< messages before those that count; fewer large ones
  std::size_t samples = 1000;    ///< messages that count at most
  std::size_t samples_min = 12;  ///< and at least
  double latency_s = 0.4;        ///< after this time only the least number of messages is sent
  double throughput_warm_up_s = 0.05;
  double throughput_s = 0.15;  ///< for which messages are sent as fast as possible
};

/// How often each thing is measured, and how long.
struct Scale {
  int rounds = 3;
  std::vector<std::uint32_t> sizes{16, 1 << 10, 16 << 10, 128 << 10, 1 << 20, bytes_max};
  Pace pace{};
  std::vector<std::size_t> readers{1, 2, 4, 8};
  std::vector<std::uint32_t> sizes_of_readers{16, 1 << 20};
  Pace pace_of_readers{.samples = 400, .latency_s = 0.12, .throughput_s = 0.1};
};

/// The scale of a run that takes less than two minutes.
Scale quick_scale();

/// The samples that writers and readers of all contenders keep: as many as fit into 4 MiB, 4 to 64.
std::uint32_t depth_of(std::uint32_t bytes);

/// "16 B", "128 KiB", "8 MiB".
std::string size_text(std::uint32_t bytes);

}  // namespace sft::bench::peers
