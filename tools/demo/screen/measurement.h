// Computes figures from two reports of the same role, by pure arithmetic.
#pragma once

#include <cstdint>

#include "tools/demo/roles/protocol.h"
#include "tools/demo/screen/figures.h"

namespace sft::demo {

struct Conditions {
  bool recorded = false;       ///< the subscriber's fields are recorded, not declared
  bool metered = false;        ///< its host is real, and so are its counters
  bool is_over = false;        ///< samples that have not arrived by now are lost
  std::uint64_t withheld = 0;  ///< samples, as the publisher counts them
};

/// Returns all figures of a subscriber except its name, its host and the size of the whole message. `begin`
/// was reported before the first sample; `published` counts the samples since then.
SubscriberFigures measure(const SubscriberReport& begin, const SubscriberReport& now, std::uint64_t published,
                          const Conditions& conditions);

}  // namespace sft::demo
