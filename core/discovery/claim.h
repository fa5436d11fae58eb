// A claim: all that one speaker says of one endpoint.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/control/control.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

struct Claim {
  Speaker speaker;
  std::shared_ptr<const Endpoint> endpoint;
  std::optional<Request> request{};  ///< the newest of this speaker
  bool alive = true;
  Time ended{};                           ///< when the claim was alive last, if it is not
  std::optional<Time> contested_since{};  ///< since when it differs from the claim that is believed
  bool refused = false;
  bool untrue = false;  ///< came by a link that is made anew: counts as long as there is no other claim

  /// A claim has a request in two places: this is the sequence of the newer one.
  std::uint64_t asked() const {
    return std::max(request ? request->sequence : 0, endpoint->request.sequence);
  }
  void end(Time now) {
    if (alive) ended = now;
    alive = false;
  }
};

/// An announcement with a large description counts as several: the limits of announcements (claim_counts.h)
/// limit the bytes that are kept, too.
inline std::size_t weight_of(const Endpoint& endpoint) {
  constexpr std::size_t bytes_of_one = 8192;
  return std::max<std::size_t>(1, (endpoint.type_description.size() + bytes_of_one - 1) / bytes_of_one);
}

/// Describes an endpoint to people.
inline std::string name_of(const Endpoint& endpoint) {
  return "of topic '" + endpoint.topic + "' of node '" + endpoint.node + "'";
}

/// True if two participants announce the same.
inline bool say_the_same(const Endpoint& a, Endpoint b) {
  b.announcer = a.announcer;
  b.request.announcer = a.request.announcer;
  return a == b;
}

}  // namespace sft::core
