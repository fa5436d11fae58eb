// Pure functions that derive the events between two states of a publisher or subscriber.
#pragma once

#include <vector>

#include "sft/event.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {

/// `type` is the message type, which is needed to name fields.
std::vector<Event> events_between(const PublisherStatus& before, const PublisherStatus& after,
                                  const TypeSupport& type);
/// `reliability` is what the subscriber asks for.
std::vector<Event> events_between(const SubscriberStatus& before, const SubscriberStatus& after,
                                  const TypeSupport& type, Reliability reliability = best_effort);

}  // namespace sft::core
