// The time of a node that follows the topic "/clock" (NodeOptions::use_sim_time): the time in the newest
// sample. The sample is taken when the program asks for the time, so the clock needs no thread, and wakes
// none.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

#include "core/sync/mutex.h"
#include "sft/dynamic.h"

namespace sft::core {

/// Any thread may use the clock.
class SimulatedClock {
 public:
  // The topic and its type, as in ROS 2.
  static constexpr const char* topic = "/clock";
  static constexpr const char* type_name = "rosgraph_msgs/Clock";
  static constexpr const char* type_text =
      "builtin_interfaces/Time clock\n"
      "================================================================================\n"
      "MSG: builtin_interfaces/Time\n"
      "int32 sec\n"
      "uint32 nanosec\n";
  /// The time after which a missing publisher of the topic is logged.
  static constexpr std::chrono::seconds timeout{5};

  explicit SimulatedClock(DynamicSubscriber&& samples) : samples_(std::move(samples)) {}

  /// Returns the time of the newest sample, or 0 if none has arrived yet.
  std::chrono::nanoseconds now();

 private:
  Mutex mutex_;
  DynamicSubscriber samples_ SFT_GUARDED_BY(mutex_);
  std::atomic<std::int64_t> now_ns_{0};
};

}  // namespace sft::core
