// The policies of one endpoint, their checks on entry, and the rules by which an offer satisfies a request.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "sft/options.h"
#include "sft/qos.h"
#include "sft/result.h"

namespace sft::core {

using sft::Qos;

/// Errors name the option and what it may be.
Result<Qos> qos_of(const PublisherOptions& options);
Result<Qos> qos_of(const SubscriberOptions& options);
/// Returns the period that a request carries for a maximum rate, rounded to microseconds; 0 if there is no
/// maximum rate.
Result<std::uint32_t> min_period_us_of(double max_rate_hz);

struct QosConflict {
  QosPolicy policy = QosPolicy::none;  ///< the first that does not fit
  std::string reason;                  ///< every one that does not, with both values
};
QosConflict conflict_between(const Qos& offered, const Qos& requested);

/// "none", "250 ms", "1500 us"
std::string text_of(std::chrono::nanoseconds duration);

}  // namespace sft::core
