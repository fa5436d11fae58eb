// One reader of this node, for one selection of a subscriber: connects its ports to the writers that the
// negotiation wants it to hear, tells these writers what it asks for, and looks after promises and after
// connections by which nothing arrives. The agent's.
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

  /// Connects to the writers that the reader should hear, and disconnects from others. `unattached` counts
  /// the connections in shared memory, of all readers, whose writers have not shown up there.
  void reconcile(std::size_t& unattached);
  /// Connections of this reader in shared memory whose writers have not shown up there.
  std::size_t unattached() const;
  struct Connections {
    bool changed = false;        ///< the desired states are to be asked for again
    bool waiting = false;        ///< some connection in shared memory is not complete yet
    std::uint64_t arrivals = 0;  ///< differs from what it was if samples have come by shared memory meanwhile
  };
  /// Sends the writers a request that says which of them the reader hears by now.
  Connections look_after_connections();
  /// The memory of the port is gone, or another daemon's. What has come by the port can be taken for a while.
  void drop_memory();
  /// True if a connection failed that may be tried again.
  bool may_try_again(Time now) const;

  // Requests.

  /// Other fields, parts of them, conditions or another maximum rate may be needed: the program has said so,
  /// or the recorder has found it. True if the desired states are to be asked for again.
  bool requirement_changed();
  /// Tells others the request as it is now.
  void send_request();
  /// Accepts no more samples under earlier requests, from writers that have gone, and by lost memory, once
  /// none can be in flight.
  void forget_what_was_in_flight(Time now);

  // Life.

  void watch_promises(Time now);
  void asserted(const std::vector<EndpointId>& writers);
  /// How long the next look can wait, no longer than `longest`.
  std::chrono::nanoseconds pace(std::chrono::nanoseconds longest) const;
  /// Watches the callback, which is for all selections of the subscriber. Null but for the first one.
  CallbackMonitor* callback() const { return callback_.get(); }
  /// Sets connections up anew by which nothing arrives, although their writer sends, as its node says.
  /// `reported`: the progress of writers that has just been told. `held_up`: a callback of this node may hold
  /// up what arrives. True if any was.
  bool restart_stalled(const std::vector<Progress>& reported, bool held_up, Time now);
  /// True if others have to report on the topic: nothing has arrived from some writer for a while, or the
  /// reader has asked for a lease.
  bool awaits_reports(Time now);

  /// Tells the user what has happened.
  void report_events();
  /// The writers that match, each with an account.
  std::vector<EndpointId> matching_writers() const;

 private:
  struct Connecting {
    Retry memory;
    Retry network;
    std::chrono::seconds network_preferred{0};  ///< the pause of shared memory after it was deaf last
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
  EndpointId id_;
  std::shared_ptr<SubscriberCore> core_;
  std::size_t selection_;
  Feed& feed_;  ///< of the core
  std::shared_ptr<BorrowingReader> memory_;
  std::shared_ptr<NetworkReader> network_;
  // By writer:
  std::map<EndpointId, Hearing> heard_;  ///< what is in force
  std::map<EndpointId, Connecting> connecting_;
  std::map<EndpointId, RequestMonitor> watched_;
  std::map<EndpointId, ArrivalWatchdog> watchdogs_;
  std::map<EndpointId, Time>
      departed_;                        ///< writers of which datagrams may still be in flight, and since when
  Time memory_lost_at_ = Time::max();   ///< while what came by it can be taken; max: long ago
  Time others_asked_at_ = Time::max();  ///< when other samples were asked for last; max: long ago
  const std::unique_ptr<CallbackMonitor> callback_;
  Qos requested_;
  AcceptedRequests accepted_;
  SubscriberStatus reported_;  ///< the state up to which events were told
  bool has_changes_ = false;   ///< the state may differ from told_
  std::uint64_t losses_reported_ = 0;
};

}  // namespace sft::core
