// sftd's configuration file:
//
//   total_mib = 320        # for samples, cut into sizes by sftd; or instead each size by itself:
//   idle_exit_s = 0        # end after being without clients for so long; 0: never
//   log_level = "info"     # error, warning, info, debug
//
//   [[pool]]
//   size_kib = 64          # of a sample: header, index and body
//   count = 500
//
//   [limits]
//   processes = 300
//   publishers_per_process = 506
//   subscribers_per_process = 1024
//
//   [access]
//   writers = "sft_writers"
//   readers = "sft_readers"
//
// Everything may be left out. What is not known, or has a value that cannot be, is refused: a setting that is
// silently not in force costs more than a daemon that does not start.
#pragma once

#include <optional>
#include <string>

#include "sft/result.h"
#include "shm_transport/sftd/log.h"
#include "shm_transport/sftd/settings.h"

namespace sft::shm {

struct Config {
  DaemonSettings settings{};
  std::optional<LogLevel> log_level{};
};

/// Errors read "FILE:LINE: KEY: what is wrong: what to do".
Result<Config> read_config(const std::string& file);

}  // namespace sft::shm
