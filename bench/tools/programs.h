// Programs that this benchmark runs, and the publisher of clouds that several of them read.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/contender.h"

namespace sft::bench {

/// Starts a program on a core, with its standard output in a file.
pid_t start_program(int core, std::vector<std::string> words, const std::string& output);
/// Does the same for the command sft.
pid_t start_sft(int core, std::vector<std::string> arguments, const std::string& output);
/// Returns the last document of JSON in a file, which has one in all or one in each line; null if there is
/// none.
nlohmann::json last_json(const std::string& file);

struct Clouds {
  std::uint32_t rows = 128;  ///< of the cloud of bench/selection; 128: 6.3 MB
  std::uint64_t count = UINT64_MAX;
  std::int64_t period_us = 0;  ///< 0: as fast as a reliable subscriber takes them
};

/// The state of a publisher of clouds, in shared memory.
struct Stage {
  std::atomic<std::int64_t> begun_at{0};  ///< the time of its first sample; 0: it has not begun
  std::atomic<bool> over{false};          ///< true: it ends early
};

/// Publishes clouds as loans in shared memory, from when a subscriber is served on. Their data are not
/// written, because in a real driver the device would write them. Returns the exit code of the process.
int publish_clouds(const Clouds& clouds, Stage& stage);

}  // namespace sft::bench
