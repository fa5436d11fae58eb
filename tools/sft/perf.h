// `sft perf`: measures latency, rate and cost between this machine and others.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "tools/perf/ping.h"
#include "tools/sft/session.h"

namespace sft::tool {

struct PerfOptions {
  bool answers = false;  ///< true: pong or sub, which serve the side that sends
  perf::Plan plan{};
  // The message, for the side that sends.
  std::string type{};                 ///< empty: bytes
  std::string value{};                ///< YAML or JSON
  std::optional<std::size_t> size{};  ///< bytes of its data
  std::string like{};                 ///< a topic of which one sample is the message
  std::string fail_if{};
  std::string svg{};  ///< a file for the picture
};

ExitCode run(const PerfOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
