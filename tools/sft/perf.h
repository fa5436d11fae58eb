// `sft perf`: measures latency, rate and cost between this machine and others.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "tools/perf/ping.h"
#include "tools/sft/session.h"

namespace sft::tool {

struct PerfOptions {
  bool answers = false;  ///< true: the command is pong or sub, which serves the sending side
  perf::Plan plan{};
  // The following members describe the message. They are used by the sending side.
  std::string type{};                 ///< the type of the message; empty: plain bytes
  std::string value{};                ///< the message as YAML or JSON
  std::optional<std::size_t> size{};  ///< the number of bytes of its data
  std::string like{};                 ///< a topic; one of its samples is taken as the message
  std::string fail_if{};
  std::string svg{};  ///< the file for a picture of the results
};

ExitCode run(const PerfOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
