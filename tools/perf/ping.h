// The side of a run that sends: at the times of a schedule, to sides that answer or only count.
#pragma once

#include <sft/sft.h>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/perf/message.h"
#include "tools/perf/result.h"
#include "tools/terminal/stop.h"

namespace sft::perf {

struct Plan {
  bool answers = true;  ///< false: only to count what arrives
  std::string fields = "*";
  bool beside_whole = false, beside_udp = false, beside_tcp = false;
  double rate_hz = 100;  ///< 0, only without answers: as fast as possible
  double for_s = 10;     ///< of each lane
  bool reliable = false, loans = false;
  TransportChoice transport = TransportChoice::automatic;
  std::size_t sides = 1;  ///< how many sides have to answer
  double timeout_s = 5;
  std::string raw_file{};  ///< not empty: each sample's times are written there
};

/// Called about once a second with a line about the run.
using Progress = std::function<void(const std::string&)>;

/// Runs the whole plan. Returns an error if there are no figures at all: no side answers in time, or
/// something is wrong with the plan. A run that is stopped or fails later returns the figures so far.
Result<Outcome> measure(Node node, const DynamicType& type, std::shared_ptr<const Payload> payload,
                        const Plan& plan, tool::Stop& stop, const Progress& progress);

}  // namespace sft::perf
