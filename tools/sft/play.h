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
  std::vector<std::string> topics{};  ///< empty: all
  std::vector<std::string> remap{};   ///< "points:=replay/points"
  double rate = 1;
  double start_s = 0;  ///< from the first message on
  double for_s = 0;    ///< of the recording's time; 0: up to its end
  bool loop = false;
  std::optional<std::size_t> wait_for{};  ///< subscribers of each topic
  double clock_hz = 0;                    ///< 0: /clock is not published
};

ExitCode run(const PlayOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
