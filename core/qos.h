// The policies of one endpoint, their checks on entry, and the rules by which an offer satisfies a request.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "sft/options.h"
#include "sft/qos.h"
#include "sft/typesupport/result.h"

namespace sft::core {

/// What a writer offers or a reader requests. Durations of 0: none.
struct Qos {
  Reliability reliability = Reliability::best_effort;
  Durability durability = Durability::volatile_;
  std::chrono::nanoseconds deadline{0};
  Liveliness liveliness = Liveliness::automatic;
  std::chrono::nanoseconds liveliness_lease{0};
  // These take no part in matching:
  std::chrono::nanoseconds lifespan{0};  ///< writers
  std::uint32_t history_depth = 1;       ///< writers: samples kept for late readers; readers: until taken
  friend bool operator==(const Qos&, const Qos&) = default;
};

/// Errors name the option and what it may be.
Result<Qos> qos_of(const PublisherOptions& options);
Result<Qos> qos_of(const SubscriberOptions& options);
/// What is sent of a maximum rate, rounded; 0 where there is none.
Result<std::uint32_t> min_period_us_of(double max_rate_hz);

struct QosConflict {
  QosPolicy policy = QosPolicy::none;  ///< the first that does not fit
  std::string reason;                  ///< every one that does not, with both values
};
QosConflict conflict_between(const Qos& offered, const Qos& requested);

/// "none", "250 ms", "1500 us"
std::string text_of(std::chrono::nanoseconds duration);

}  // namespace sft::core
