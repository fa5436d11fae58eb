// Reads the configuration file of sftd. A complete file looks like this:
//
//   total_mib = 1024       # memory for samples, which sftd divides into chunks; instead, give [[pool]]
//   idle_exit_s = 0        # sftd ends after this time without programs; 0: never
//   log_level = "info"     # error, warning, info or debug
//
//   [[pool]]               # chunks of one size; the file can have several such sections
//   size_kib = 64          # the largest sample in a chunk: header, index and body
//   count = 500            # the number of chunks
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
// Every entry may be left out. An unknown key or a wrong value is refused, because a setting that is
// silently ignored does more harm than a daemon that does not start.
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

/// An error message has the form "FILE:LINE: KEY: what is wrong: what to do".
Result<Config> read_config(const std::string& file);

}  // namespace sft::shm
