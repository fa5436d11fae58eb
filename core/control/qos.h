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

/// Return the checked policies. Errors name the option and its valid values.
Result<Qos> qos_of(const PublisherOptions& options);
Result<Qos> qos_of(const SubscriberOptions& options);
/// Returns the period of a maximum rate, as it is in requests, rounded to microseconds; 0: no maximum rate.
Result<std::uint32_t> min_period_us_of(double max_rate_hz);

struct QosConflict {
  QosPolicy policy = QosPolicy::none;  ///< the first policy that does not fit
  std::string reason;                  ///< names all policies that do not fit, with both values
};
QosConflict conflict_between(const Qos& offered, const Qos& requested);

/// Returns a duration as text: "none", "250 ms", "1500 us".
std::string text_of(std::chrono::nanoseconds duration);

}  // namespace sft::core
