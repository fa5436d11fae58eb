// What has happened between two states of a publisher or subscriber. Pure.
#pragma once

#include <vector>

#include "sft/event.h"
#include "sft/status.h"

namespace sft::core {

std::vector<Event> events_between(const PublisherStatus& before, const PublisherStatus& after);
std::vector<Event> events_between(const SubscriberStatus& before, const SubscriberStatus& after);

}  // namespace sft::core
