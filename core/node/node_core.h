// What is behind a node: it owns the transports, discovery, the threads and the endpoints' memory, opens
// publishers and subscribers, and passes everything that happens on to the agent's thread, where the
// reconciler acts on it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/node/endpoint_roster.h"
#include "core/node/reconciler.h"
#include "core/platform/agent.h"
#include "core/platform/doorbell.h"
#include "core/platform/forked.h"
#include "core/report/node_log.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "core/subscribe/dispatcher.h"
#include "core/sync/event_count.h"
#include "sft/detail/untyped.h"
#include "sft/domain.h"
#include "sft/dynamic_type.h"
#include "sft/options.h"

namespace sft::core {

class NodeCore final : private DiscoveryListener {
 public:
  struct Parts {
    std::unique_ptr<Transport> shm;  ///< null where the node must not use it
    std::unique_ptr<Transport> udp;
    std::shared_ptr<BufferPool> heap;  ///< all memory for samples outside of shared memory
  };

  /// `options` with its defaults resolved (domain, configuration).
  static Result<std::shared_ptr<NodeCore>> open(const NodeOptions& options, Parts parts);
  ~NodeCore();

  Result<detail::untyped::Publisher> open_publisher(const std::shared_ptr<NodeCore>& self,
                                                    std::string_view topic, const TypeSupport& type,
                                                    const PublisherOptions& options);
  /// The type, which then lives as long as the node: what publishes, sends and remembers refers to it.
  const TypeSupport& kept(const DynamicType& type);
  Result<detail::untyped::Subscriber> open_subscriber(const std::shared_ptr<NodeCore>& self,
                                                      std::string_view topic, const TypeSupport& type,
                                                      detail::untyped::Requirement requirement,
                                                      const SubscriberOptions& options,
                                                      detail::untyped::Callback callback,
                                                      std::shared_ptr<const void> type_owner = {});
  Result<DynamicType> find_type(std::string_view topic, std::chrono::nanoseconds timeout);
  std::vector<TopicInfo> topics();
  DomainSnapshot domain();
  Result<AccountInquiry> ask_accounts(const std::shared_ptr<NodeCore>& self, std::string_view topic);
  NodeStatus status() const;
  NodeSnapshot snapshot() const;

 private:
  NodeCore(const NodeOptions& options, Parts parts);
  static void dispose(NodeCore* node);
  std::uint32_t shm_depth_of(const Endpoint& reader);
  Result<std::uint32_t> slot_for(bool has_callback, bool pollable);
  Result<std::uint32_t> take_slot();
  void give_slot_back(std::uint32_t slot);
  Endpoint new_endpoint(Role role, std::string_view topic, const TypeSupport& type,
                        TransportChoice choice) const;
  Result<void> keep_ways_for(Endpoint& writer) const;
  static Result<void> check_topic(std::string_view topic);
  Result<void> check_endpoint(std::string_view topic, const TypeSupport& type, TransportChoice choice) const;

  // DiscoveryListener: posted to the agent.
  void endpoint_seen(Endpoint endpoint) override;
  void endpoint_departed(EndpointId id) override;
  void endpoint_lost(EndpointId id) override;
  void request_received(Request request) override;
  void liveliness_asserted(Assertion assertion) override;
  void node_lost(NodeId id) override;
  void control_malformed(std::string why) override;
  void links_changed(const std::string& summary) override;  // by the agent itself
  void link_was_deaf(const std::string& what) override;     // likewise
  void other_release_found(const std::string& what) override;

  /// Calls `question` on the agent's thread, which alone may look at the reconciler, and returns its answer.
  template <class Question>
  auto ask_agent(Question question) -> decltype(question());

  bool may_use(TransportKind kind, TransportChoice choice) const;

  const OfOneProcess of_one_process_;
  std::mutex kept_mutex_;
  std::map<std::string, DynamicType> kept_types_;  ///< by their descriptions; outlive all below

  const NodeOptions options_;
  const NodeId id_;
  const std::uint64_t network_;
  const std::unique_ptr<Transport> shm_;
  const std::unique_ptr<Transport> udp_;
  const std::shared_ptr<BufferPool> heap_;
  const std::unique_ptr<DoorbellPage> bells_;
  std::mutex slots_mutex_;
  std::vector<std::uint32_t> free_slots_;  ///< of bells_, beside those of the dispatchers
  std::atomic<std::uint64_t> control_malformed_{0};
  std::atomic<std::uint64_t> links_renewed_{0};
  std::atomic<std::chrono::steady_clock::time_point> next_complaint_{};  ///< of the malformed
  NodeLog log_;                                                          ///< the agent's
  EventCount endpoints_changed_;
  mutable EndpointRoster roster_;

  Dispatcher dispatcher_;
  Dispatcher poller_;                       ///< tells file descriptors what came in shared memory
  std::unique_ptr<Discovery> discovery_;    ///< its threads post to the agent
  std::unique_ptr<Reconciler> reconciler_;  ///< the agent's own; set before that starts
  Agent agent_;
};

}  // namespace sft::core
