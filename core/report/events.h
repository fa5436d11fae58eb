// Pure functions that derive events from the differences between an earlier and a later state of a
// publisher or subscriber.
#pragma once

#include <vector>

#include "sft/event.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {

/// Returns the events of a publisher. `type` is the message type, from which the names of fields are taken.
std::vector<Event> events_between(const PublisherStatus& before, const PublisherStatus& after,
                                  const TypeSupport& type);
/// Returns the events of a subscriber. `reliability` is the policy that the subscriber requests.
std::vector<Event> events_between(const SubscriberStatus& before, const SubscriberStatus& after,
                                  const TypeSupport& type, Reliability reliability = best_effort);

}  // namespace sft::core
