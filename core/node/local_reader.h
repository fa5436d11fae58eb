// One reader of this node, which serves one selection of a subscriber. It connects its ports to the writers
// from which it should receive according to the negotiation, sends requests to these writers, watches their
// deadlines and leases, and restarts connections over which nothing arrives. Used by the agent only.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
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
    /// The port for UDP, which must accept the first request already, since datagrams may arrive as soon as
    /// the request is announced; null if the reader must not use UDP.
    std::shared_ptr<NetworkReader> network;
    std::size_t selection = 0;  ///< the number of the selection that this reader serves
  };
  /// `node` must outlive this object. `endpoint` is the endpoint that is added to the negotiation.
  LocalReader(NodeContext& node, const Endpoint& endpoint, Parts parts);

  SubscriberCore& core() const { return *core_; }
  SubscriberPorts& ports() const { return feed_.ports(); }
  /// Stops receiving samples. Called when the reader is removed.
  void close();

  // Functions about connections.

  /// Connects to the writers from which the reader should receive, and disconnects from other writers.
  /// `unattached` counts the connections in shared memory, of all readers, that are not attached to their
  /// writers yet.
  void reconcile(std::size_t& unattached);
  /// Returns the number of connections of this reader in shared memory that are not attached to their writers
  /// yet.
  std::size_t unattached() const;
  struct Connections {
    bool changed = false;        ///< true: the negotiation must be asked again for the desired states
    bool waiting = false;        ///< true: a connection in shared memory is not established yet
    std::uint64_t arrivals = 0;  ///< a number that changes when samples arrive by shared memory
  };
  /// Examines the connections. If they have changed, sends a new request to the writers, because requests
  /// list the connections.
  Connections look_after_connections();
  /// Gives up the port in shared memory, because the memory is lost or belongs to another daemon. Samples
  /// that have arrived by the port can still be taken for a while.
  void drop_memory();
  /// Returns true if a connection has failed and may be tried again now.
  bool may_try_again(Time now) const;

  // Functions about requests.

  /// Called when the program or the recorder may need other fields, parts of them, conditions or another
  /// maximum rate. Returns true if the negotiation must be asked again for the desired states.
  bool requirement_changed();
  /// Sends the present request to other nodes.
  void send_request();
  /// Stops accepting three kinds of samples when none of them can be in flight any more: samples for earlier
  /// requests, samples of departed writers, and samples in lost memory.
  void forget_what_was_in_flight(Time now);

  // Functions about deadlines, leases and the state of writers.

  void watch_promises(Time now);
  void asserted(const std::vector<EndpointId>& writers);
  /// Returns the time until watch_promises() must be called again, at most `longest`.
  std::chrono::nanoseconds pace(std::chrono::nanoseconds longest) const;
  /// Returns the monitor of the callback, or null. Only the reader of the first selection has a monitor,
  /// because all selections share the callback.
  CallbackMonitor* callback() const { return callback_.get(); }
  /// Sets up connections anew over which nothing arrives although the writer's node reports that the writer
  /// sends. `reported` is the progress of writers that has just been reported. `held_up`: a callback of
  /// this node may have delayed arrivals. Returns true if a connection was set up anew.
  bool restart_stalled(const std::vector<Progress>& reported, bool held_up, Time now);
  /// Returns true if the reader needs reports of other nodes on the topic, because nothing has arrived from
  /// some writer for a while, or because the reader has requested a lease.
  bool awaits_reports(Time now);

  /// Reports events to the user.
  void report_events();
  /// Returns the writers of SFT that match. Each of them has an account.
  std::vector<EndpointId> matching_writers() const;

 private:
  /// A writer from which the reader should receive.
  struct Writer {
    Hearing hearing;  ///< what is wanted, with the connections in force
    Retry memory;
    Retry network;
    /// The last pause before shared memory was tried again for this writer after it had failed.
    std::chrono::seconds network_preferred{0};
    std::optional<RequestMonitor> monitor;  ///< set if a deadline or a lease has to be watched
    ArrivalWatchdog watchdog;
  };

  void connect(const Hearing& wanted, Writer& writer, std::size_t& unattached);
  bool connect_network(const Hearing& wanted, const Hearing& before, Retry& retry);
  bool connect_memory(const Hearing& wanted, const Hearing& before, Retry& retry, std::size_t& unattached);
  Result<void> connect_in_memory(const Source& source);
  void disconnect_departed(const std::vector<Hearing>& wanted);
  bool look_after_history(const ReaderPort& port, EndpointId writer, Connections& connections);
  void accept();
  bool is_stalled(Writer& from, const std::vector<Progress>& reported, bool held_up, Time now);
  void restart(Writer& from, Time now);

  NodeContext& node_;
  std::shared_ptr<SubscriberCore> core_;
  std::size_t selection_;
  Feed& feed_;  ///< a part of `core_`
  std::shared_ptr<BorrowingReader> memory_;
  std::shared_ptr<NetworkReader> network_;
  VanillaHearing vanilla_;
  std::map<EndpointId, Writer> writers_;
  /// The times at which writers departed; their datagrams may still be in flight.
  std::map<EndpointId, Time> departed_;
  /// The time of the loss of shared memory, as long as samples in the lost memory can still be taken,
  /// otherwise Time::max().
  Time memory_lost_at_ = Time::max();
  /// The time of the last change of the request, or Time::max() if no earlier request matters any more.
  Time others_asked_at_ = Time::max();
  const std::unique_ptr<CallbackMonitor> callback_;
  Qos requested_;
  AcceptedRequests accepted_;
  SubscriberStatus reported_;  ///< the state that the last reported events led to
  bool has_changes_ = false;   ///< the state may differ from reported_
  std::uint64_t losses_reported_ = 0;
};

}  // namespace sft::core
