// The core of a node. It owns the transports, discovery, the threads and the memory of the endpoints, opens
// publishers and subscribers, and posts all events to the agent's thread, where the reconciler handles them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/names/remapping.h"
#include "core/node/endpoint_opening.h"
#include "core/node/endpoint_registry.h"
#include "core/node/kept_types.h"
#include "core/node/reconciler.h"
#include "core/node/wake_slots.h"
#include "core/platform/agent.h"
#include "core/platform/clock.h"
#include "core/platform/forked.h"
#include "core/report/log_setting.h"
#include "core/report/node_log.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "core/subscribe/dispatcher.h"
#include "core/sync/event_count.h"
#include "core/vanilla/ros_discovery.h"
#include "sft/detail/untyped.h"
#include "sft/domain.h"
#include "sft/dynamic_type.h"
#include "sft/options.h"

namespace sft::core {

class NodeCore final {
 public:
  struct Parts {
    std::unique_ptr<SharedMemory> memory;  ///< null if the node must not use shared memory
    std::unique_ptr<Network> network;
    std::shared_ptr<BufferPool> heap;  ///< the pool for samples that are not in shared memory
    LogSetting log{};
    Remapping names{};
    RosDiscovery ros{};        ///< where unmodified nodes of DDS are looked for
    std::string ros_distro{};  ///< the distribution of ROS 2 that the environment names; may be empty
  };

  /// In `options`, the defaults (domain, configuration) must have been replaced by actual values, and the
  /// name must be the full name of the node.
  static Result<std::shared_ptr<NodeCore>> open(const NodeOptions& options, Parts parts);
  ~NodeCore();

  Result<detail::untyped::Publisher> open_publisher(const std::shared_ptr<NodeCore>& self,
                                                    std::string_view topic, const TypeSupport& type,
                                                    const PublisherOptions& options);
  /// Keeps the type as long as the node lives, and returns the kept type.
  const TypeSupport& kept(const DynamicType& type) { return kept_types_.keep(type); }
  Result<detail::untyped::Subscriber> open_subscriber(const std::shared_ptr<NodeCore>& self,
                                                      EndpointOpening::ReaderOrder order);
  Result<DynamicType> find_type(std::string_view topic, std::chrono::nanoseconds timeout);
  std::vector<TopicInfo> topics();
  DomainSnapshot domain();
  Result<AccountInquiry> ask_accounts(const std::shared_ptr<NodeCore>& self, std::string_view topic);
  /// See Node::interrupt().
  void interrupt() noexcept;
  bool is_interrupted() const noexcept { return wake_slots_.interrupted().load(); }
  NodeStatus status() const;
  NodeSnapshot snapshot() const;

 private:
  NodeCore(const NodeOptions& options, Parts parts);
  static void dispose(NodeCore* node);
  NodeOptions::LogSink posted(const NodeOptions::LogSink& sink);

  /// Returns a function that makes the agent call `act`, which it does not do once it has stopped. Any thread
  /// may call the function, even after the node was destroyed.
  std::function<void()> by_agent(void (NodeCore::*act)());
  // Called by the agent only.
  void take_events();
  void vanilla_changed() { reconciler_->take(VanillaChanged{}); }

  /// Makes discovery report all publishers from now on, and all subscribers if `readers_too` is true. Called
  /// by the agent only.
  void hear(bool readers_too);
  std::vector<TableEntry> copies_of_endpoints() const;
  /// Calls `question` on the agent's thread, which is the only thread that may use the reconciler. Returns
  /// the answer.
  template <class Question>
  auto ask_agent(Question question) -> decltype(question());

  const OfOneProcess of_one_process_;
  KeptTypes kept_types_;  ///< must outlive all members below

  const NodeOptions options_;
  const NodeId id_;
  const std::uint64_t network_id_;
  const std::unique_ptr<SharedMemory> memory_;
  const std::unique_ptr<Network> network_;
  WakeSlots wake_slots_;
  CallbackThread callbacks_;  ///< for callbacks about events and readers, and for the log
  NodeLog log_;               ///< posts its lines to callbacks_
  EventCount endpoints_changed_;
  mutable EndpointRegistry registry_;

  Dispatcher dispatcher_;
  Dispatcher poller_;  ///< makes the file descriptors of subscribers readable when
                       ///< samples arrive in shared memory
  const std::shared_ptr<Agent> shared_agent_ = std::make_shared<Agent>();  ///< discovery posts to it
  Agent& agent_ = *shared_agent_;
  std::unique_ptr<Discovery> discovery_;
  std::unique_ptr<Reconciler> reconciler_;  ///< changed by the agent only; set before the agent starts
  std::optional<EndpointOpening> opening_;  ///< set once discovery is open
};

}  // namespace sft::core
