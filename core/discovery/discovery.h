// Announces our endpoints and requests on all links of this host, and reports everybody else's: the control
// topics of Cyclone DDS, once for each address of the host (discovery.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/discovery_listener.h"
#include "core/platform/clock.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

struct DiscoveryOptions {
  std::uint32_t domain = 0;
  DiscoverySettings settings{};
  std::string user_config{};  ///< XML texts or names of files
  ThreadSettings threads{};   ///< of Cyclone's threads
};

class Discovery {
 public:
  /// `listener` outlives the discovery.
  static Result<std::unique_ptr<Discovery>> open(const DiscoveryOptions& options,
                                                 DiscoveryListener& listener);
  virtual ~Discovery() = default;

  struct Configuration {
    std::string summary{};                ///< for people: how and where nodes are found
    std::vector<std::string> warnings{};  ///< for people: which of the user's settings do not hold, and why
    std::vector<std::string> remarks{};   ///< parts of the summary: interfaces that are not there, or not yet
    std::vector<std::string> interfaces{};  ///< in use; empty where that is the program's own choice
    bool waits_for_network = false;         ///< as of DesiredLinks
  };
  /// The present configuration. Any thread.
  virtual Configuration configuration() const = 0;

  // One thread at a time.

  /// Listens to what others announce of all their endpoints of that role from now on, and to the requests of
  /// readers. What they have announced before comes soon, too. A node that announces an endpoint hears of
  /// those that may match it anyway: endpoints of the other role, of the same topic.
  virtual Result<void> hear(Role role) = 0;
  /// A publisher that this process knows of, whatever its topic is.
  struct KnownPublisher {
    std::string topic;
    std::string node;  ///< the name of its node
  };
  /// Returns the publishers of that type, those of this process too. The process knows all publishers while
  /// any of its nodes has a subscriber.
  virtual std::vector<KnownPublisher> publishers_of(std::string_view type_name) const = 0;
  /// Announces an endpoint of ours, or that it has changed. What cannot be written now, here and in the next
  /// two functions, is written again by look_after() until others have it, with a warning.
  virtual void announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual void send(const Request& request) = 0;
  /// Asks all nodes for reports, until this node asks for something else.
  virtual void inquire(const std::set<Inquiry>& inquiries) = 0;
  struct Inquiries {
    std::set<Inquiry> all{};  ///< of all nodes, this one too
    std::uint64_t made = 0;   ///< differs from what it was if another node has begun to ask
  };
  virtual Inquiries inquiries() const = 0;
  /// Tells the nodes that inquire. The report may get lost.
  virtual void report(const NodeReport& report) = 0;
  /// When the latest newcomer among other processes was heard first; Time{} if there was none. What it
  /// announces may be yet to come. Any thread.
  virtual Time newcomer_at() const = 0;
  /// The participants that are not SFT's, as the links hear them: nodes of DDS and ROS 2.
  struct Vanilla {
    bool is_there = false;
    std::uint64_t came = 0;  ///< how many have come so far
    friend bool operator==(const Vanilla&, const Vanilla&) = default;
  };
  /// Any thread.
  virtual Vanilla vanilla() const = 0;
  /// To be called often: takes interfaces into use and out of use, and lets nodes that have not heard of us,
  /// or have lost us, find us. Cyclone does that by itself every now and then. Returns when this node has to
  /// call it again at the latest; Time::max() if it need not hurry.
  virtual Time look_after(Time now) = 0;
};

}  // namespace sft::core
