// Announces the endpoints and requests of a node on all links of this host, and reports the endpoints and
// requests of all other nodes. It exchanges them on SFT's control topics through Cyclone DDS, with one
// participant for each address of the host (discovery.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/control/control.h"
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

/// A listener is notified of what other nodes announce: once of each item, however many links bring it. It is
/// called by Cyclone's threads and by agents of this process, one call at a time. They must not be held up,
/// so the listener should only post the news.
class DiscoveryListener {
 public:
  virtual void endpoint_seen(Endpoint endpoint) = 0;
  virtual void endpoint_departed(EndpointId id) = 0;
  /// The process of the endpoint is silent. If it returns, endpoint_seen() is called again.
  virtual void endpoint_lost(EndpointId id) = 0;
  virtual void request_received(Request request) = 0;
  /// A node has reported on its own endpoints. Called for nodes that inquire.
  virtual void report_received(NodeReport report) = 0;
  /// A control sample, or the type description in one, was refused.
  virtual void control_malformed(std::string why) = 0;
  /// The result of Discovery::vanilla() has changed.
  virtual void vanilla_changed() {}
  /// The interfaces in use have changed.
  virtual void links_changed(std::string /*summary*/) {}
  /// A record of another process was missing on one link, so that link was made anew.
  virtual void link_was_renewed(std::string /*what*/) {}
  /// The user has to know that a participant has another release, that a peer by name has no address, or that
  /// the program has closed the sockets.
  virtual void warned(std::string /*what*/) {}

 protected:
  ~DiscoveryListener() = default;
};

class Discovery {
 public:
  /// `listener` outlives the discovery.
  static Result<std::unique_ptr<Discovery>> open(const DiscoveryOptions& options,
                                                 DiscoveryListener& listener);
  virtual ~Discovery() = default;

  struct Configuration {
    std::string summary{};                ///< for people: how and where nodes are found
    std::vector<std::string> warnings{};  ///< for people: which of the user's settings do not apply, and why
    std::vector<std::string> remarks{};   ///< parts of the summary: interfaces that are not there, or not yet
    std::vector<std::string> interfaces{};  ///< in use
    bool waits_for_network = false;         ///< see DesiredLinks
  };
  /// The present configuration. Any thread.
  virtual Configuration configuration() const = 0;

  // One thread at a time.

  /// Reports from now on all endpoints of that role that other nodes announce, and the requests of readers.
  /// Earlier announcements are reported soon, too. Without this call, a node is notified only of endpoints
  /// that may match its own: those of the other role, of the same topic.
  virtual Result<void> hear(Role role) = 0;
  /// A publisher that this process knows of, whatever its topic is.
  struct KnownPublisher {
    std::string topic;
    std::string node;  ///< the name of its node
  };
  /// Returns the publishers of that type, including those of this process. The process knows all publishers
  /// while any of its nodes has a subscriber.
  virtual std::vector<KnownPublisher> publishers_of(std::string_view type_name) const = 0;
  /// Announces an endpoint of this node, or a change of it. If that cannot be written now, look_after()
  /// warns, and writes it again until it succeeds. The same is true of the next two functions.
  virtual void announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual void send(const Request& request) = 0;
  /// Asks all nodes for reports, until the next call.
  virtual void inquire(const std::set<Inquiry>& inquiries) = 0;
  struct Inquiries {
    std::set<Inquiry> all{};  ///< of all nodes, this one too
    std::uint64_t made = 0;   ///< changes when a node begins to ask
  };
  virtual Inquiries inquiries() const = 0;
  /// Sends a report to the nodes that inquire. It may get lost.
  virtual void report(const NodeReport& report) = 0;
  /// Returns when a participant of another process was last found; Time{} if none was. Its announcements may
  /// still be on their way. Any thread.
  virtual Time newcomer_at() const = 0;
  /// The participants that are not SFT's, as the links find them: nodes of DDS and ROS 2.
  struct Vanilla {
    bool is_there = false;
    std::uint64_t came = 0;  ///< the number of participants that have come so far
    friend bool operator==(const Vanilla&, const Vanilla&) = default;
  };
  /// Any thread may call this.
  virtual Vanilla vanilla() const = 0;
  /// Must be called often. Opens and closes links as interfaces come and go, and lets nodes that have not
  /// found this process, or have lost it, find it. Cyclone itself does that only now and then. Returns the
  /// time by which this node must call it again; Time::max() if there is no need.
  virtual Time look_after(Time now) = 0;
};

}  // namespace sft::core
