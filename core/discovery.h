// Announces our endpoints and requests on all links of this host, and reports everybody else's: the control
// topics of Cyclone DDS, once for each address of the host (discovery.md).
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
  ThreadSettings threads{};   ///< of Cyclone's threads
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

/// Told what others announced, each thing once, however many links it comes by. Called on Cyclone's threads,
/// which must not be held up: post it and return. One call at a time.
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
  /// Other interfaces are used now. On the thread that calls look_after().
  virtual void links_changed(const std::string& /*summary*/) {}
  /// Somebody was not heard any more on one link, though he is there, and so the link was made anew, or could
  /// not be. Likewise.
  virtual void link_was_deaf(const std::string& /*what*/) {}
  /// Somebody is there with whom this node cannot speak. Likewise.
  virtual void other_release_found(const std::string& /*what*/) {}

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

  virtual LifeSigns life_signs() const = 0;
  struct Configuration {
    std::string summary{};                ///< for people: how and where nodes are found
    std::vector<std::string> warnings{};  ///< for people: which of the user's settings do not hold, and why
    std::vector<std::string> remarks{};   ///< parts of the summary: interfaces that are not there, or not yet
    std::vector<std::string> interfaces{};  ///< in use; empty where that is the program's own choice
    bool waits_for_network = false;         ///< as of DesiredLinks
  };
  /// As it is at present. Any thread.
  virtual Configuration configuration() const = 0;

  // All that follows: one thread at a time.

  /// Announces an endpoint of ours, or that it has changed.
  virtual Result<void> announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual Result<void> send(const Request& request) = 0;
  /// Of this node, and of writers of ours. May get lost; to be called at least after each pause of the life
  /// signs.
  virtual void assert_liveliness(const Assertion& assertion) = 0;
  /// To be called often: takes interfaces into use and out of use, and lets nodes that have not heard of us,
  /// or have lost us, find us. Cyclone does that by itself every now and then.
  virtual void look_after(std::chrono::steady_clock::time_point now, bool somebody_is_missing) = 0;
};

}  // namespace sft::core
