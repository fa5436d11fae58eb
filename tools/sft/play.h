// `sft play`: publishes recorded samples again.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

struct PlayOptions {
  std::vector<std::string> files{};
  std::vector<std::string> topics{};  ///< the topics to play; empty: all
  std::vector<std::string> remap{};   ///< new names, such as "points:=replay/points"
  double rate = 1;
  double start_s = 0;  ///< where to begin, in seconds after the first message
  double for_s = 0;    ///< the duration in seconds, in the time of the recording; 0: up to its end
  bool loop = false;
  std::optional<std::size_t> wait_for{};  ///< the number of subscribers of each topic to wait for
  double clock_hz = 0;                    ///< the rate of /clock; 0: /clock is not published
};

ExitCode run(const PlayOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
