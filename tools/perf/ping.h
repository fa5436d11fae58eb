// The sending side of a run. It sends by a schedule to sides that answer the samples or only count them.
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
  bool answers = true;  ///< false: the other sides only count samples
  std::string fields = "*";
  bool beside_whole = false, beside_udp = false, beside_tcp = false;
  double rate_hz = 100;  ///< the rate; 0: as fast as possible, which is allowed only without answers
  double for_s = 10;     ///< the duration of each lane in seconds
  bool reliable = false, loans = false;
  TransportChoice transport = TransportChoice::automatic;
  std::size_t sides = 1;  ///< the number of sides that have to answer
  double timeout_s = 5;
  std::string raw_file{};  ///< the file for the times of each sample; empty: no such file is written
};

/// A function that is called about once a second with a line about the run.
using Progress = std::function<void(const std::string&)>;

/// Runs the whole plan. Returns an error if there are no results at all, because no side answers in time or
/// the plan is wrong. If the run is stopped or fails later, returns the results so far.
Result<Outcome> measure(Node node, const DynamicType& type, std::shared_ptr<const Payload> payload,
                        const Plan& plan, tool::Stop& stop, const Progress& progress);

}  // namespace sft::perf
