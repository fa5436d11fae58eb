// The endpoints that participants have announced under the keys of a control topic. A participant uses a key
// again for another endpoint (own_keys.h), and Cyclone may leave out that it withdrew the first one, since it
// keeps the last sample of a key only. Pure, one thread at a time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/participants.h"

namespace sft::core {

class HeardKeys {
 public:
  /// Returns the endpoint that this announcement ends: the participant had announced it under the same key.
  std::optional<EndpointId> announced(const Participants::Guid& by, std::uint64_t key, EndpointId id) {
    const auto [entry, is_new] = endpoints_.try_emplace({key, by}, id);
    const EndpointId before = std::exchange(entry->second, id);
    return before == id ? std::nullopt : std::optional(before);
  }
  /// Returns the endpoint that the participant withdraws, which may be one that only another participant has
  /// announced under that key. Returns nothing if no participant has announced one.
  std::optional<EndpointId> withdrawn(const Participants::Guid& by, std::uint64_t key) {
    if (const auto ended = endpoints_.extract({key, by})) return ended.mapped();
    const auto other = endpoints_.lower_bound({key, Participants::Guid{}});
    return other != endpoints_.end() && other->first.first == key ? std::optional(other->second)
                                                                  : std::nullopt;
  }
  /// Returns the endpoints of all participants under a key that no participant writes any more.
  std::vector<EndpointId> unheard(std::uint64_t key) {
    std::vector<EndpointId> ended;
    auto entry = endpoints_.lower_bound({key, Participants::Guid{}});
    for (; entry != endpoints_.end() && entry->first.first == key; entry = endpoints_.erase(entry))
      ended.push_back(entry->second);
    return ended;
  }
  /// Forgets the keys of a participant that is gone.
  void forget(const Participants::Guid& participant) {
    std::erase_if(endpoints_, [&](const auto& entry) { return entry.first.second == participant; });
  }

 private:
  std::map<std::pair<std::uint64_t, Participants::Guid>, EndpointId> endpoints_;
};

}  // namespace sft::core
