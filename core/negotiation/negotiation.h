// The negotiation decides who gets what, by which path and under which mask. It is a pure state machine:
// events go in, desired states come out, and there is no I/O and no clock in it. It keeps a table of
// endpoints, ours and others', and derives from the table what each of our writers should serve and what each
// of our readers should hear. The order of events therefore does not matter. negotiation.md has the rules as
// a table.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/early_requests.h"
#include "core/negotiation/pair.h"
#include "core/negotiation/qos_watch.h"
#include "core/negotiation/table_shares.h"
#include "core/negotiation/type_comparisons.h"
#include "core/platform/clock.h"
#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

/// The desired state of one of our writers.
struct Serving {
  bool memory_port = false;  ///< be reachable in shared memory, even if no reader is attached yet
  std::vector<Route> memory;
  std::vector<Route> network;
  /// Over the network, to those of `memory` that listen there: for what does not go that way.
  std::vector<Route> fallback;
  std::vector<Route> unreached;       ///< would be in `memory`, but the port cannot tell these of samples
  std::vector<ReaderStatus> readers;  ///< all of the topic, with reasons
  bool lease_requested = false;       ///< some reader wants to know whether the writer lives
  bool samples_tell = true;           ///< and each of these gets every sample
  bool history_owed = false;          ///< some route has a history

  /// Returns true if both send the same to the same readers. What status() tells of these readers may differ.
  bool serves_like(const Serving& other) const {
    return memory_port == other.memory_port && memory == other.memory && network == other.network &&
           fallback == other.fallback;
  }
  friend bool operator==(const Serving&, const Serving&) = default;
};

/// One writer that one of our readers should hear.
struct Hearing {
  Source source;
  Qos offered;
  std::uint32_t owed = 0;  ///< retained samples that should come first
  bool memory = false;     ///< connect to it in shared memory
  bool network = false;
  WriterStatus status;
};

class Negotiation {
 public:
  /// Entries of other nodes beyond these are refused and counted (table_shares.h has the rules).
  struct Limits {
    std::size_t endpoints = 4096;
    std::chrono::seconds forget_lost_after{60};
    std::size_t of_announcer = 1024;
    std::size_t of_topic = 64;
  };
  /// A request that is this much ahead of the last one counts only if the reader's own node sends it.
  static constexpr std::uint64_t jump_max = std::uint64_t{1} << 32;

  Negotiation() : Negotiation(Limits{}) {}
  explicit Negotiation(const Limits& limits);

  // Events. Each returns whether anything may have changed, that is, whether to ask for the desired states
  // again.
  bool self_changed(const Self& self);
  /// Our endpoints are reached there from now on, and others from there.
  bool network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links);
  /// `type` outlives the endpoint. The endpoint's host and network are taken from Self, its addresses from
  /// network_changed().
  void local_added(const Endpoint& endpoint, const TypeSupport& type);
  void local_removed(EndpointId id);
  bool endpoint_seen(const Endpoint& endpoint);
  bool endpoint_departed(EndpointId id);
  bool endpoint_lost(EndpointId id, Time now);
  /// All endpoints of a node are as lost, until it is heard of again; they are not forgotten for that.
  bool node_lost(NodeId id);
  bool node_returned(NodeId id);
  bool request_received(const Request& request);
  /// One of our readers needs other fields now.
  bool requirement_changed(EndpointId reader, const FieldMask& mask);
  bool rate_changed(EndpointId reader, std::uint32_t min_period_us);
  /// Tells that samples of a writer now arrive at one of our readers by that path, or no longer arrive.
  bool connection_changed(EndpointId reader, EndpointId writer, TransportKind path, bool connected);
  /// Something of a durable writer has come for one of our readers alone.
  bool history_began(EndpointId reader, EndpointId writer);
  /// Tells that all retained samples for that reader have arrived.
  bool history_came(EndpointId reader, EndpointId writer);
  /// All that one of our writers has sent to a late reader alone has left. Takes effect once the reader says
  /// that it has begun to come.
  bool history_given(EndpointId writer, EndpointId reader);
  /// Tells why the port of one of our writers cannot ring that reader's doorbell in shared memory; empty if
  /// it can.
  bool reach_changed(EndpointId writer, EndpointId reader, const std::string& why_not);
  bool tick(Time now);

  // Desired states, from the table as it is.
  Serving serving(EndpointId writer) const;
  std::vector<Hearing> hearing(EndpointId reader) const;
  /// Our endpoint as it should be announced, with the request in force.
  const Endpoint* local(EndpointId id) const;
  /// The same for the next time that it is announced, in a revision of its own.
  const Endpoint* next_announcement(EndpointId id);
  std::size_t endpoints() const { return entries_.size(); }
  std::uint64_t definitions_compared() const { return comparisons_.compared(); }
  /// All endpoints but the lost ones; ours too. Valid until the next event.
  std::vector<const Endpoint*> present() const;
  /// Returns true if the table has an endpoint of that node.
  bool knows(NodeId id) const;
  /// Takes the progress of a writer as its node reports it. A report about a writer of another node changes
  /// nothing.
  void progressed(NodeId node, const Progress& progress);
  /// Null while nothing was told of that. Valid until the next event.
  const Progress* progress_of(EndpointId id) const;
  /// Null if there is none of that id. Valid until the next event.
  const Endpoint* known(EndpointId id) const;
  /// Returns true if some endpoint is lost.
  bool misses_somebody() const;

  /// Announcements and requests that were refused or dropped, because a table was full.
  std::uint64_t ignored() const { return ignored_; }
  /// The same by the name of the node that they came from, where one was named, since this was last asked.
  std::map<std::string, std::uint64_t> take_refusals() { return std::exchange(refusals_, {}); }

  /// An endpoint of ours that somebody else has withdrawn, announced or requested something for.
  struct Contested {
    EndpointId id = 0;
    std::string how;  ///< for people
  };
  /// Returns the endpoints that were contested since the last call. Their revision, and the sequence of their
  /// request, are now greater than what was said in their name. They have to be announced anew.
  std::vector<Contested> take_contested() { return std::exchange(contested_, {}); }

 private:
  struct Entry {
    Endpoint endpoint;
    const TypeSupport* type = nullptr;              ///< of our own endpoints
    std::optional<Time> lost_since;                 ///< by discovery: if it returns, it is seen again
    bool silent = false;                            ///< its node is not heard of
    std::uint64_t arrival = 0;                      ///< counts entries
    std::set<EndpointId> history_given{};           ///< of our own writers: to these readers
    std::set<EndpointId> history_came{};            ///< of our own readers: from these writers
    std::map<EndpointId, std::string> unreached{};  ///< of our own writers: readers in memory, and why
    std::optional<Progress> progress{};             ///< of writers, as it was told last
    bool lost() const { return lost_since || silent; }
  };
  HostToken host_of(Role role) const;
  Verdict judge(const Entry& writer, const Entry& reader, int& definitions) const;
  static void look_after_lease(const Endpoint& reader, const ReaderStatus& status, Serving& serving);
  ReaderStatus serve(const Entry& writer, const Entry& reader, const Verdict& verdict,
                     Serving& serving) const;
  void hear_no_more_than_possible(std::vector<Hearing>& hearing) const;
  static std::uint32_t history_owed(const Entry& writer, const Endpoint& reader);
  void erase(EndpointId id);
  bool admit(const Endpoint& endpoint);
  void index(const Endpoint& endpoint);
  void unindex(const Endpoint& endpoint);
  static bool is_outdated(const Entry& entry, const Endpoint& endpoint);
  void hear_of_our_own(Entry& own, const Endpoint& said);
  void contest(Entry& own, const Request& said, std::string how);
  UdpAddress address_of(const Endpoint& reader) const;
  void adopt_early_request(Entry& entry);
  static bool adopt(Entry& entry, const Request& request);
  void owe_what_has_not_begun(const Endpoint& reader);
  std::vector<const Entry*> others(const Entry& entry) const;

  Limits limits_;
  Self self_;
  std::optional<std::vector<UdpAddress>> addresses_;  ///< once they were told
  std::vector<Link> links_;
  std::map<EndpointId, Entry> entries_;
  std::map<std::string, std::set<EndpointId>, std::less<>> topics_;  ///< of all entries
  TableShares shares_;                                               ///< of those that are not ours
  EarlyRequests early_requests_;
  std::vector<Contested> contested_;
  std::map<std::string, std::uint64_t> refusals_;
  mutable TypeComparisons comparisons_;
  std::uint64_t ignored_ = 0;
  std::uint64_t arrivals_ = 0;
};

}  // namespace sft::core
