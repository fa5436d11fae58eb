// Announces the endpoints and requests of a node on all links of this host, and reports the endpoints and
// requests of all other nodes. It exchanges them on SFT's control topics through Cyclone DDS, with one
// participant for each address of the host (discovery.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <variant>
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
  ThreadSettings threads{};   ///< the settings of Cyclone's threads
};

/// An endpoint of another node has come, has changed, or answers again. A subscriber has its latest request.
/// The nodes of a process share the value.
using EndpointSeen = std::shared_ptr<const Endpoint>;
/// The endpoint was withdrawn.
struct EndpointDeparted {
  EndpointId id = 0;
};
/// No heartbeats of the endpoint's process come any more. If the process is found again, the endpoint is seen
/// again.
struct EndpointLost {
  EndpointId id = 0;
};
/// The result of Discovery::vanilla() has changed.
struct VanillaChanged {};
/// A text for the log.
struct DiscoveryNews {
  enum class Kind : std::uint8_t {
    malformed,     ///< a control sample, or the type description in one, was malformed or forged, and refused
    too_much,      ///< a record was refused, because a process has announced more than one may
    link_renewed,  ///< a record of another process was missing on one link, which was replaced by a new one
    links_changed,  ///< the interfaces in use have changed; the text is the summary of the configuration
    warning         ///< for example, a participant has another release, or a peer's name has no address
  };
  Kind kind{};
  std::string text{};
  std::uint64_t times = 1;  ///< the number of refusals since the last news of this kind, of which the text
                            ///< describes the first one; else 1
};
/// One of the things that a node learns of other nodes: each of them once, even if several links bring it. A
/// request comes after its endpoint. Reports come only to nodes that have called inquire().
using DiscoveryEvent = std::variant<EndpointSeen, EndpointDeparted, EndpointLost, Request, NodeReport,
                                    VanillaChanged, DiscoveryNews>;

class Discovery {
 public:
  /// Any thread calls `wake` when there is something for take_events(), once until that is called. It may do
  /// so even after the returned object was destroyed, so `wake` must own what it uses.
  static Result<std::unique_ptr<Discovery>> open(const DiscoveryOptions& options, std::function<void()> wake);
  virtual ~Discovery() = default;

  struct Configuration {
    std::string summary{};                ///< for people: how and where nodes are found
    std::vector<std::string> warnings{};  ///< for people: which of the user's settings do not apply, and why
    std::vector<std::string> remarks{};   ///< the parts of the summary about interfaces that are missing
    std::vector<std::string> interfaces{};  ///< the interfaces in use
    bool waits_for_network = false;         ///< see DesiredLinks
  };
  /// Returns the present configuration. Any thread may call this.
  virtual Configuration configuration() const = 0;

  // The following functions must be called by only one thread at a time.

  /// Returns what has happened since the last call, in order.
  virtual std::vector<DiscoveryEvent> take_events() = 0;
  /// Reports from now on all endpoints of that role that other nodes announce, and the requests of readers.
  /// Endpoints that were announced earlier are reported soon, too. Without this call, a node is notified
  /// only of endpoints that may match its own: those with the other role and the same topic.
  virtual void hear(Role role) = 0;
  /// A publisher that this process knows of, whatever its topic is.
  struct KnownPublisher {
    std::string topic;
    std::string node;  ///< the name of its node
  };
  /// Returns the publishers of that type, including those of this process. The result is complete only
  /// while some node of this process has a subscriber.
  virtual std::vector<KnownPublisher> publishers_of(std::string_view type_name) const = 0;
  /// Announces an endpoint of this node, or a change of it. If the record cannot be written now,
  /// look_after() warns and tries again until it succeeds. The same is true of the next two functions.
  virtual void announce(const Endpoint& endpoint) = 0;
  virtual void withdraw(EndpointId id) = 0;
  virtual void send(const Request& request) = 0;
  /// Asks all nodes for reports. The inquiries hold until the next call replaces them.
  virtual void inquire(const std::set<Inquiry>& inquiries) = 0;
  struct Inquiries {
    std::set<Inquiry> all{};  ///< the inquiries of all nodes, including this one
    std::uint64_t made = 0;   ///< a number that changes when a node begins to ask
  };
  virtual Inquiries inquiries() const = 0;
  /// Sends a report to the nodes that have called inquire(). The report may get lost.
  virtual void report(const NodeReport& report) = 0;
  /// The participants on the links that do not belong to SFT: nodes of DDS and ROS 2.
  struct Vanilla {
    bool is_there = false;
    std::uint64_t came = 0;  ///< the number of participants that have come so far
    friend bool operator==(const Vanilla&, const Vanilla&) = default;
  };
  /// Any thread may call this.
  virtual Vanilla vanilla() const = 0;
  /// Must be called often. Opens and closes links as interfaces come and go. Announces this process again
  /// to nodes that have not found it, or have lost it, since Cyclone itself repeats announcements only
  /// rarely. Returns the time by which this node must call it again; Time::max() if no further call is
  /// needed.
  virtual Time look_after(Time now) = 0;
};

}  // namespace sft::core
