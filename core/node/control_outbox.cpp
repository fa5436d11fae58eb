#include "core/node/control_outbox.h"

namespace sft::core {

void ControlOutbox::announce(EndpointId id, Time now) {
  Unsaid& unsaid = unsaid_[id];
  unsaid.announcement = true;
  say(id, unsaid, now);
}

void ControlOutbox::request(EndpointId reader, Time now) {
  Unsaid& unsaid = unsaid_[reader];
  unsaid.request = true;
  say(reader, unsaid, now);
}

void ControlOutbox::withdraw(EndpointId id) {
  unsaid_.erase(id);
  discovery_.withdraw(id);
}

void ControlOutbox::look(Time now) {
  for (auto item = unsaid_.begin(); item != unsaid_.end();) {
    auto& [id, unsaid] = *item++;  // say() may erase it
    if (unsaid.retry.due(now)) say(id, unsaid, now);
  }
}

/// An announcement contains the request. But a node that knows the endpoint already may not look at it there.
void ControlOutbox::say(EndpointId id, Unsaid& unsaid, Time now) {
  if (negotiation_.local(id) == nullptr) return static_cast<void>(unsaid_.erase(id));
  Result<void> written;
  if (unsaid.announcement) {
    written = discovery_.announce(*negotiation_.next_announcement(id));
    unsaid.announcement = !written;
  }
  if (written && unsaid.request) {
    written = discovery_.send(negotiation_.local(id)->request);
    unsaid.request = !written;
  }
  if (written) return static_cast<void>(unsaid_.erase(id));
  if (unsaid.retry.failed(written.error().message, now))
    log_.write(LogLevel::warning, written.error().message + "; it is tried again until it succeeds");
}

}  // namespace sft::core
