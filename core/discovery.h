// The control topics on Cyclone DDS: announces our endpoints and requests, reports everybody else's. The
// only part of the core that sees Cyclone, which is behind the .cpp.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/control.h"
#include "sft/options.h"
#include "sft/typesupport/result.h"

namespace sft::core {

struct DiscoveryOptions {
  std::uint32_t domain = 0;
  DiscoverySettings settings{};
  std::string user_config{};  ///< XML texts or names of files
};

/// How often a node says that it lives, and after how long without that it is lost: six in a row may get
/// lost. Of ten nodes that lose a fifth of all packets, one is then lost falsely every ten minutes or so, and
/// returns with the next.
struct LifeSigns {
  std::chrono::milliseconds pause;
  std::chrono::milliseconds lease;
};
inline constexpr LifeSigns life_signs_to_all{std::chrono::milliseconds(650), std::chrono::milliseconds(5000)};
/// Without multicast, where each node has to be told by itself.
inline constexpr LifeSigns life_signs_to_each{std::chrono::milliseconds(1950),
                                              std::chrono::milliseconds(14'000)};

/// Told what others announced. Called on Cyclone's threads, which must not be held up: post it and return.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// Its node stopped answering; if it returns, the endpoint is seen again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// A node says every now and then that it lives, and which of its writers do.
  virtual void liveliness_asserted(Assertion assertion) = 0;
  /// It has not said so for its lease.
  virtual void node_lost(NodeId id) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;

 protected:
  ~DiscoveryListener() = default;
};

/// Control samples of another version are refused.
std::uint32_t control_protocol_version();

class Discovery {
 public:
  /// `listener` outlives the discovery.
  static Result<std::unique_ptr<Discovery>> open(const DiscoveryOptions& options,
                                                 DiscoveryListener& listener);
  virtual ~Discovery() = default;

  struct Configuration {
    std::string summary{};                ///< for people: how nodes are found
    std::vector<std::string> warnings{};  ///< for people: which of the user's settings do not hold, and why
    LifeSigns life_signs = life_signs_to_all;
  };
  virtual const Configuration& configuration() const = 0;

  /// Announces an endpoint of ours, or that it has changed.
  virtual Result<void> announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual Result<void> send(const Request& request) = 0;
  /// Of this node, and of writers of ours. May get lost; to be called at least after each pause of the life
  /// signs.
  virtual void assert_liveliness(const Assertion& assertion) = 0;
  /// Lets nodes that have not heard of us, or have lost us, find us at once. Cyclone does it by itself every
  /// now and then.
  virtual void greet() = 0;
};

}  // namespace sft::core
