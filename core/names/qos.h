// The policies of one endpoint, their checks when an endpoint is opened, and the rules by which an offer
// satisfies a request.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "sft/options.h"
#include "sft/qos.h"
#include "sft/result.h"

namespace sft::core {

using sft::Qos;

/// These functions return the checked policies of the options. Errors name the option and its valid values.
Result<Qos> qos_of(const PublisherOptions& options);
Result<Qos> qos_of(const SubscriberOptions& options);
/// Returns the minimum time between two samples that a maximum rate allows, in microseconds, as requests
/// contain it. 0: no maximum rate.
Result<std::uint32_t> min_period_us_of(double max_rate_hz);

/// These functions return a sentence for each option that was set and has no effect because of the other
/// options. `udp` and `shm` say which transports the endpoint may use.
std::vector<std::string> options_without_effect(const NodeOptions& options);
std::vector<std::string> options_without_effect(const PublisherOptions& options, bool udp);
std::vector<std::string> options_without_effect(const SubscriberOptions& options, bool shm, bool recorded);

struct QosConflict {
  QosPolicy policy = QosPolicy::none;  ///< the first policy whose offered value does not satisfy the request
  /// A text with all policies whose offers do not satisfy the requests, both values of each, and the
  /// options to set.
  std::string reason;
};
QosConflict conflict_between(const Qos& offered, const Qos& requested);

/// Returns a duration as text: "none", "250 ms", "1500 us".
std::string text_of(std::chrono::nanoseconds duration);

}  // namespace sft::core
