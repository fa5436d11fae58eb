// `sft echo`: prints the samples of a topic, or some of their fields.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

enum class Format : std::uint8_t { yaml, json, csv };

struct EchoOptions {
  std::string topic{};
  std::vector<std::string> fields{"*"};  ///< one text for each selection
  std::uint64_t count = 0;               ///< the number of samples to print; 0: the command runs until the
                                         ///< user stops it
  Format format = Format::yaml;
  /// True: long arrays and texts are not shortened on a terminal. Other output is never shortened.
  bool full = false;
  double max_rate_hz = 0;  ///< the maximum rate; 0: all samples
};

ExitCode run(const EchoOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
