// From what roles report to figures: pure arithmetic on two reports of the same role.
#pragma once

#include <cstdint>

#include "tools/demo/roles/protocol.h"
#include "tools/demo/screen/figures.h"

namespace sft::demo {

struct Conditions {
  bool recorded = false;       ///< the subscriber's fields are recorded, not declared
  bool metered = false;        ///< its host is real, and so are its counters
  bool is_over = false;        ///< what has not arrived by now is lost
  std::uint64_t withheld = 0;  ///< of the samples, as the publisher counts them for it
};

/// All figures of a subscriber but its name and host and the size of the whole message. `begin` was reported
/// before the first sample; `published` are the samples since.
SubscriberFigures measure(const SubscriberReport& begin, const SubscriberReport& now, std::uint64_t published,
                          const Conditions& conditions);

/// What a host sends per second of control traffic.
double control_bytes_per_s(const Traffic& begin, const Traffic& now);

}  // namespace sft::demo
