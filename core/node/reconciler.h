// The loop of a node. It takes events from discovery and from the program, passes them to the negotiation,
// brings the node's endpoints to the states that the negotiation wants, and reports changes to other nodes
// and to the user. Used by the agent only, except for functions that are marked.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/negotiation/negotiation.h"
#include "core/node/domain_snapshot.h"
#include "core/node/local_endpoints.h"
#include "core/node/misspelt_topics.h"
#include "core/node/node_context.h"
#include "core/node/port_attempts.h"
#include "core/node/reports.h"
#include "core/node/second_servers.h"
#include "core/node/tick_pace.h"
#include "core/node/transport_monitor.h"
#include "core/node/vanilla_access.h"
#include "core/platform/clock.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"
#include "core/subscribe/dispatcher.h"

namespace sft::core {

class Reconciler final {
 public:
  /// All arguments must outlive this object. A transport is null if the node must not use that transport.
  Reconciler(std::uint64_t network_id, SharedMemory* memory, Network* network, Discovery& discovery,
             Dispatcher& dispatcher, NodeLog& log, VanillaAccess::Setup vanilla = {});

  void add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);
  void add_reader(const Endpoint& endpoint, LocalReader::Parts parts);
  /// Withdraws an endpoint and gives up its ports.
  void remove(EndpointId id);
  /// Called when the requirement of a reader of this node may have changed, by the program or the recorder.
  void requirement_changed(EndpointId id);
  /// Called when the program has asserted the liveliness of a writer of this node.
  void program_asserts(EndpointId writer);

  /// Takes an event of discovery. VanillaChanged must also be passed when DDS readers or writers have come or
  /// gone.
  void take(const DiscoveryEvent& event, Time now = std::chrono::steady_clock::now());
  /// From now on, unmodified nodes are looked for even without a publisher or a subscriber, for vanilla().
  void observe();

  /// Does the work that is due in transports, discovery and endpoints. Returns the time until the next call.
  std::chrono::milliseconds tick(Time now = std::chrono::steady_clock::now());
  /// Brings the endpoints to the states that are desired now. Must be called after any of the functions
  /// above. Returns the time until the next call of tick().
  std::chrono::milliseconds reconcile();

  /// Returns all endpoints that are known and not lost, including those of this node. Valid until the next
  /// event.
  std::vector<const TableEntry*> endpoints() const { return negotiation_.table().present(); }
  VanillaView vanilla() const { return vanilla_.view(); }
  Reports& reports() { return reports_; }

  // The functions for any thread.
  /// The counts of what discovery has refused and mended so far.
  struct DiscoveryCounts {
    std::atomic<std::uint64_t> malformed{0}, ignored{0}, links_renewed{0};
  };
  const DiscoveryCounts& counts() const { return counts_; }
  /// Other threads may call only those functions of the returned object that are marked
  /// (transport_monitor.h).
  const TransportMonitor& transports() const { return transports_; }

 private:
  void take_report(const NodeReport& report, Time now);
  void log_news(const DiscoveryNews& news);
  bool look_after_vanilla(Time now);
  void report(std::vector<EndpointId> living, Time now);
  void watch_promises(Time now);
  void look_at_arrivals(const std::vector<Progress>& reported, Time now);
  void look_after_memory(Time now);
  void look_after_addresses(Time now);
  void look_after_endpoints(Time now);
  void log_long_waits(const LocalReader& reader, const CallbackMonitor::LongWaits& waits);
  bool look_after_connections(Time now);
  void announce(EndpointId id);
  void announce_all();
  void settle();
  std::chrono::milliseconds pace(Time now) const;

  Discovery& discovery_;
  Dispatcher& dispatcher_;
  NodeLog& log_;
  TransportMonitor transports_;
  Negotiation negotiation_;
  MisspeltTopics misspelt_topics_;
  SecondServers second_servers_;
  PortAttempts attempts_;
  VanillaAccess vanilla_;
  NodeContext context_;
  LocalEndpoints ours_;
  /// Readers that were removed during their own callbacks, until these callbacks have returned.
  std::map<EndpointId, LocalReader> departing_;
  Reports reports_;
  TickPace tick_pace_;
  Time discovery_looks_at_{};  ///< the latest time of the next call of Discovery::look_after()
  Time held_up_at_{};          ///< the last time at which a callback that takes long was seen
  DiscoveryCounts counts_;
  Time next_complaint_{};  ///< the earliest time of the next line about refused control traffic
  bool observes_ = false;  ///< see observe()
  bool dirty_ = false;     ///< something changed since the last reconcile()
};

}  // namespace sft::core
