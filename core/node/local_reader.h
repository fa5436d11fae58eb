// One reader of this node, for one selection of a subscriber: connects its ports to the writers that the
// negotiation wants it to receive from, sends them its requests, watches their deadlines and leases, and
// restarts connections by which nothing arrives. Used by the agent only.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "core/negotiation/qos_monitor.h"
#include "core/node/arrival_watchdog.h"
#include "core/node/callback_monitor.h"
#include "core/node/node_context.h"
#include "core/node/vanilla_hearing.h"
#include "core/platform/clock.h"
#include "core/subscribe/subscriber_core.h"

namespace sft::core {

class LocalReader {
 public:
  struct Parts {
    std::shared_ptr<SubscriberCore> core;
    std::shared_ptr<NetworkReader> network;  ///< null if UDP is ruled out; accepts the first mask already
    std::size_t selection = 0;               ///< the number of the selection that this reader asks for
  };
  /// `node` outlives this object. `endpoint` is the one that is added to the negotiation.
  LocalReader(NodeContext& node, const Endpoint& endpoint, Parts parts);

  SubscriberCore& core() const { return *core_; }
  SubscriberPorts& ports() const { return feed_.ports(); }
  /// Stops taking samples. It is called when the reader is removed.
  void close();

  // Connections.

  /// Connects to the writers that the reader should receive from, and disconnects from others. `unattached`
  /// counts the connections in shared memory, of all readers, that are not attached to their writers yet.
  void reconcile(std::size_t& unattached);
  /// Returns how many connections of this reader in shared memory are not attached to their writers yet.
  std::size_t unattached() const;
  struct Connections {
    bool changed = false;        ///< the negotiation must be asked for the desired states again
    bool waiting = false;        ///< some connection in shared memory is not complete yet
    std::uint64_t arrivals = 0;  ///< changes when samples come by shared memory
  };
  /// Sends the writers a new request if the connections have changed, which the request lists.
  Connections look_after_connections();
  /// Gives up the port in shared memory, because the memory is gone, or is another daemon's. Samples that
  /// have come by the port can be taken for a while.
  void drop_memory();
  /// Returns true if a connection has failed and may be tried again now.
  bool may_try_again(Time now) const;

  // Requests.

  /// The program or the recorder may need other fields, parts of them, conditions or another maximum rate.
  /// Returns true if the negotiation must be asked for the desired states again.
  bool requirement_changed();
  /// Sends the present request to other nodes.
  void send_request();
  /// Stops accepting samples under earlier requests, from writers that have gone, and by lost memory, once
  /// none of them can be in flight any more.
  void forget_what_was_in_flight(Time now);

  // Life.

  void watch_promises(Time now);
  void asserted(const std::vector<EndpointId>& writers);
  /// Returns how long the next look can wait, `longest` at most.
  std::chrono::nanoseconds pace(std::chrono::nanoseconds longest) const;
  /// Returns the monitor of the callback. Only the reader of the first selection has one, because all
  /// selections share the callback; null for others.
  CallbackMonitor* callback() const { return callback_.get(); }
  /// Sets up connections anew by which nothing arrives although the writer's node reports that it sends.
  /// `reported`: progress of writers that has just been reported. `held_up`: a callback of this node may hold
  /// up what arrives. Returns true if a connection was set up anew.
  bool restart_stalled(const std::vector<Progress>& reported, bool held_up, Time now);
  /// Returns true if other nodes have to report on the topic: nothing has arrived from some writer for a
  /// while, or the reader has asked for a lease.
  bool awaits_reports(Time now);

  /// Reports events to the user.
  void report_events();
  /// Returns the writers of SFT that match. Each has an account.
  std::vector<EndpointId> matching_writers() const;

 private:
  struct Connecting {
    Retry memory;
    Retry network;
    std::chrono::seconds network_preferred{0};  ///< the last pause of shared memory after it failed
  };

  Hearing connect(const Hearing& wanted, const Hearing& before, std::size_t& unattached);
  bool connect_network(const Hearing& wanted, const Hearing& before, Retry& retry);
  bool connect_memory(const Hearing& wanted, const Hearing& before, Retry& retry, std::size_t& unattached);
  Result<void> connect_in_memory(const Source& source);
  void disconnect_departed(const std::map<EndpointId, Hearing>& heard);
  bool look_after_history(const ReaderPort& port, EndpointId writer, Connections& connections);
  void accept();
  void watch_matching();
  bool is_stalled(const Hearing& hearing, const std::vector<Progress>& reported, bool held_up, Time now);
  void restart(Hearing& hearing, Time now);

  NodeContext& node_;
  std::shared_ptr<SubscriberCore> core_;
  std::size_t selection_;
  Feed& feed_;  ///< belongs to `core_`
  std::shared_ptr<BorrowingReader> memory_;
  std::shared_ptr<NetworkReader> network_;
  VanillaHearing vanilla_;
  // The keys of these maps are writers:
  std::map<EndpointId, Hearing> heard_;  ///< the connections in force
  std::map<EndpointId, Connecting> connecting_;
  std::map<EndpointId, RequestMonitor> watched_;
  std::map<EndpointId, ArrivalWatchdog> watchdogs_;
  std::map<EndpointId, Time> departed_;  ///< when writers departed; datagrams may be in flight
  Time memory_lost_at_ = Time::max();    ///< while its samples can be taken; max: long ago
  Time others_asked_at_ = Time::max();   ///< when other samples were asked for last; max: long ago
  const std::unique_ptr<CallbackMonitor> callback_;
  Qos requested_;
  AcceptedRequests accepted_;
  SubscriberStatus reported_;  ///< the state up to which events were reported
  bool has_changes_ = false;   ///< the state may differ from reported_
  std::uint64_t losses_reported_ = 0;
};

}  // namespace sft::core
