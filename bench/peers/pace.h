// The number of messages of each size, and the times at which they are sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sft::bench::peers {

inline constexpr std::uint32_t bytes_max = 8 << 20;
inline constexpr std::size_t sizes_max = 8;
inline constexpr std::size_t readers_max = 8;
inline constexpr std::size_t samples_max = 4096;  ///< the maximum number of latencies of one message size

struct Pace {
  std::int64_t period_us = 200;  ///< time between two messages; longer if the previous one has not arrived
  /// The number of messages at the start that are not counted. It is smaller for large messages.
  std::size_t warm_up = 30;
  std::size_t samples = 1000;    ///< the maximum number of messages that are counted
  std::size_t samples_min = 12;  ///< the minimum number of messages that are counted
  /// The time after which messages are sent only until `samples_min` is reached.
  double latency_s = 0.4;
  double throughput_warm_up_s = 0.05;
  double throughput_s = 0.15;  ///< the time in which messages are sent as fast as possible
};

/// The number of rounds, and the length of each measurement.
struct Scale {
  int rounds = 3;
  std::vector<std::uint32_t> sizes{16, 1 << 10, 16 << 10, 128 << 10, 1 << 20, bytes_max};
  Pace pace{};
  std::vector<std::size_t> readers{1, 2, 4, 8};
  std::vector<std::uint32_t> sizes_of_readers{16, 1 << 20};
  Pace pace_of_readers{.samples = 400, .latency_s = 0.12, .throughput_s = 0.1};
};

/// Returns the scale of a run that takes less than two minutes.
Scale quick_scale();

/// Returns the number of samples that writers and readers of all contenders keep: as many as fit into 4
/// MiB, but 4 to 64.
std::uint32_t depth_of(std::uint32_t bytes);

/// Returns a size as text, such as "16 B", "128 KiB", "8 MiB".
std::string size_text(std::uint32_t bytes);

}  // namespace sft::bench::peers
