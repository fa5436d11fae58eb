// Keeps what this process has announced and requested, as it is in force, and writes it in full to each link
// that is made later. One thread at a time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "core/control/control.h"
#include "core/discovery/discovery_link.h"

namespace sft::core {

class OwnAnnouncements {
 public:
  /// Keeps an endpoint as it is now; returns it with a revision that is greater than those before, and than
  /// one that somebody else has used in its name.
  const Endpoint& announce(const Endpoint& endpoint);
  /// Returns the role of the endpoint; nothing if there is none.
  std::optional<Role> withdraw(EndpointId id);
  void request(const Request& request);

  /// The digest (control_digest.h) of all that others should know of our endpoints of that role.
  std::uint32_t digest(Role role) const;
  void write_to(DiscoveryLink& link) const;

 private:
  struct Own {
    Endpoint endpoint;
    std::optional<Request> request{};  ///< the latest one, if any was sent since the endpoint was opened
  };
  std::map<EndpointId, Own> own_;
};

}  // namespace sft::core
