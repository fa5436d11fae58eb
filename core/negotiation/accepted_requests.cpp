#include "core/negotiation/accepted_requests.h"

#include <utility>

namespace sft::core {

AcceptedRequests::AcceptedRequests(Wanted first, bool reliable) : reliable_(reliable) {
  asks_for(std::move(first), Time{});
}

void AcceptedRequests::asks_for(Wanted wanted, Time now) {
  if (!requests_.empty()) requests_.back().replaced_at = now;
  if (!reliable_) std::erase_if(requests_, [&](const Request& r) { return r.accepted.wanted == wanted; });
  requests_.push_back({.accepted = {std::move(wanted), reliable_ ? ++last_ : 0}, .asked_at = now});
  if (requests_.size() > (reliable_ ? reliable_max : best_effort_max)) requests_.erase(requests_.begin());
}

/// A best-effort reader must not accept samples for an older request for long. Another reader in this
/// process may make the same request, and this reader would then accept the samples of that reader.
bool AcceptedRequests::look(Time now) {
  if (!reliable_) {
    return std::erase_if(requests_, [&](const Request& r) {
             return r.replaced_at != Time::max() && now - r.replaced_at > in_flight_max;
           }) != 0;
  }
  bool changed = false;
  for (auto request = requests_.rbegin(); request != requests_.rend(); ++request) {
    if (request->accepted.heard) break;
    request->accepted.heard = now - request->asked_at > in_flight_max;
    changed = changed || request->accepted.heard;
  }
  return changed;
}

std::vector<Accepted> AcceptedRequests::all() const {
  std::vector<Accepted> all;
  for (const Request& request : requests_) all.push_back(request.accepted);
  return all;
}

}  // namespace sft::core
