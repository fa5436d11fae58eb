// These functions find the events between two states of a publisher or subscriber. They are pure.
#pragma once

#include <vector>

#include "sft/event.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {

/// `type` is what it publishes or subscribes to; it names fields.
std::vector<Event> events_between(const PublisherStatus& before, const PublisherStatus& after,
                                  const TypeSupport& type);
/// `reliability`: that the subscriber asks for.
std::vector<Event> events_between(const SubscriberStatus& before, const SubscriberStatus& after,
                                  const TypeSupport& type, Reliability reliability = best_effort);

}  // namespace sft::core
