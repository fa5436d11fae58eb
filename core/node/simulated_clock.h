// The time of a node that follows the topic "/clock" (NodeOptions::use_sim_time): that of the newest sample.
// The sample is taken when the program asks for the time, so the clock needs no thread, and wakes none.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

#include "core/sync/mutex.h"
#include "sft/dynamic.h"

namespace sft::core {

/// Any thread.
class SimulatedClock {
 public:
  // The topic and its type, as ROS 2 has them.
  static constexpr const char* topic = "/clock";
  static constexpr const char* type_name = "rosgraph_msgs/Clock";
  static constexpr const char* type_text =
      "builtin_interfaces/Time clock\n"
      "================================================================================\n"
      "MSG: builtin_interfaces/Time\n"
      "int32 sec\n"
      "uint32 nanosec\n";
  /// If no publisher of the topic is known after this time, the log says so.
  static constexpr std::chrono::seconds timeout{5};

  explicit SimulatedClock(DynamicSubscriber&& samples) : samples_(std::move(samples)) {}

  /// Returns the time of the newest sample; 0 until the first one has come.
  std::chrono::nanoseconds now();

 private:
  Mutex mutex_;
  DynamicSubscriber samples_ SFT_GUARDED_BY(mutex_);
  std::atomic<std::int64_t> now_ns_{0};
};

}  // namespace sft::core
