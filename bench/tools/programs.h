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

/// Starts a program on a core. Its standard output is written to the file `output`.
pid_t start_program(int core, std::vector<std::string> words, const std::string& output);
/// Starts the command sft in the same way.
pid_t start_sft(int core, std::vector<std::string> arguments, const std::string& output);
/// Returns the last JSON document in a file. The file contains one document, or one in each line. Returns
/// null if there is none.
nlohmann::json last_json(const std::string& file);

struct Clouds {
  std::uint32_t rows = 128;  ///< the rows of the cloud of bench/selection; 128 rows have 6.3 MB
  std::uint64_t count = UINT64_MAX;
  /// The time between two clouds; 0: as fast as a reliable subscriber takes them
  std::int64_t period_us = 0;
};

/// The state of a publisher of clouds, in shared memory.
struct Stage {
  std::atomic<std::int64_t> begun_at{0};  ///< the time of the first sample; 0: no sample was published yet
  std::atomic<bool> over{false};          ///< true: the publisher has to end early
};

/// Publishes clouds as loans in shared memory once a subscriber is served. Their data are not written,
/// because in a real driver the device would write them. Returns the exit code of the process.
int publish_clouds(const Clouds& clouds, Stage& stage);

}  // namespace sft::bench
