// What is behind a node: its agent, discovery, transports and endpoints, and the loop that brings the
// transports to the states that the negotiation wants.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/agent.h"
#include "core/buffer_pool.h"
#include "core/discovery.h"
#include "core/dispatcher.h"
#include "core/doorbell.h"
#include "core/negotiation.h"
#include "core/publisher_core.h"
#include "core/subscriber_core.h"
#include "core/transport.h"
#include "sft/options.h"
#include "sft/untyped.h"

namespace sft::core {

class NodeCore final : private DiscoveryListener {
 public:
  struct Parts {
    std::unique_ptr<Transport> shm;  ///< null where the node must not use it
    std::unique_ptr<Transport> udp;
  };

  /// `options` with its defaults resolved (domain, configuration).
  static Result<std::shared_ptr<NodeCore>> open(const NodeOptions& options, Parts parts);
  ~NodeCore();

  Result<untyped::Publisher> open_publisher(const std::shared_ptr<NodeCore>& self, std::string_view topic,
                                            const TypeSupport& type, const PublisherOptions& options);
  Result<untyped::Subscriber> open_subscriber(const std::shared_ptr<NodeCore>& self, std::string_view topic,
                                              const TypeSupport& type, untyped::Requirement requirement,
                                              const SubscriberOptions& options, untyped::Callback callback);
  NodeStatus status() const;

 private:
  struct Writer {
    std::shared_ptr<PublisherCore> core;
    std::shared_ptr<WriterPort> shm;
    std::optional<Serving> in_force;
  };
  struct AcceptedMask {
    FieldMask mask;
    Now replaced_at = Now::max();  ///< when something else was asked for
  };
  struct Reader {
    std::shared_ptr<SubscriberCore> core;
    std::shared_ptr<Recorder> recorder;
    std::shared_ptr<ReaderPort> shm;
    std::shared_ptr<ReaderPort> udp;
    std::map<EndpointId, Hearing> heard;
    std::vector<AcceptedMask> accepted;  ///< newest last
    std::map<EndpointId, Now> departed;  ///< writers of which datagrams may still be in flight
  };

  NodeCore(const NodeOptions& options, Parts parts);
  static void dispose(NodeCore* node);
  Result<std::uint32_t> take_slot();
  void give_slot_back(std::uint32_t slot);
  Endpoint new_endpoint(Role role, std::string_view topic, const TypeSupport& type,
                        TransportChoice choice) const;
  Result<void> check_endpoint(std::string_view topic, const TypeSupport& type, TransportChoice choice) const;

  // DiscoveryListener: posted to the agent.
  void endpoint_seen(Endpoint endpoint) override;
  void endpoint_departed(EndpointId id) override;
  void endpoint_lost(EndpointId id) override;
  void request_received(Request request) override;
  void control_malformed(std::string why) override;

  // On the agent.
  std::chrono::milliseconds tick();
  void look_after_shm();
  bool look_after_connections();
  void reconcile();
  void apply_desired_states();
  void reconcile_writer(EndpointId id, Writer& writer);
  void reconcile_reader(EndpointId id, Reader& reader);
  Hearing connect(EndpointId id, Reader& reader, const Hearing& wanted, const Hearing& before);
  Result<void> connect_shm(EndpointId id, Reader& reader, const Source& source);
  void announce(EndpointId id);
  void add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);
  void add_reader(const Endpoint& endpoint, Reader reader);
  void remove(EndpointId id);
  void requirement_changed(EndpointId id);
  void forget_what_was_in_flight(Now now);
  static void accept(Reader& reader);
  template <class Open>
  bool try_shm(Open open);
  void request_changed(EndpointId id);
  void look_after_udp(Now now);
  void drop_shm_ports();
  bool may_use(TransportKind kind, TransportChoice choice) const;
  void log(LogLevel level, const std::string& text) const;

  const NodeOptions options_;
  const std::uint64_t network_;
  const std::unique_ptr<Transport> shm_;
  const std::unique_ptr<Transport> udp_;
  const std::shared_ptr<BufferPool> heap_;
  const std::unique_ptr<DoorbellPage> bells_;
  std::mutex slots_mutex_;
  std::vector<std::uint32_t> free_slots_;  ///< of bells_; slot 0 is the dispatcher's
  std::atomic<std::uint64_t> control_malformed_{0};
  std::atomic<std::uint64_t> control_ignored_{0};

  // The agent's own.
  Negotiation negotiation_;
  std::map<EndpointId, Writer> writers_;
  std::map<EndpointId, Reader> readers_;
  Self self_;
  bool udp_failed_ = false;
  bool dirty_ = false;      ///< something changed that reconcile() has not seen
  Now next_shm_attempt_{};  ///< after failures, and the pause until then
  std::chrono::milliseconds shm_pause_{0};
  int hurried_ticks_ = 0;  ///< in a row, because some reader waits for its connection
  std::atomic<bool> shm_ready_{false};

  mutable std::mutex shm_state_mutex_;
  std::string shm_state_;  ///< for status()

  Dispatcher dispatcher_;
  Agent agent_;
  std::unique_ptr<Discovery> discovery_;  // last: its threads post to the agent
};

}  // namespace sft::core
