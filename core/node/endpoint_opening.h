// Does the part of opening publishers and subscribers that does not need the agent: checks the options,
// describes the endpoint for other nodes, opens its UDP port and makes its core. After that, the agent adds
// the endpoint to the reconciler. Any thread may use it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/node/local_reader.h"
#include "core/node/node_names.h"
#include "core/node/reconciler.h"
#include "core/node/wake_slots.h"
#include "core/platform/agent.h"
#include "core/publish/publisher_core.h"
#include "core/report/callback_thread.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "core/subscribe/dispatcher.h"
#include "sft/detail/untyped.h"
#include "sft/options.h"

namespace sft::core {

class EndpointOpening {
 public:
  /// The parts of the node. All of them must outlive this object. A transport is null if the node must not
  /// use it.
  struct Node {
    const NodeOptions& options;
    std::shared_ptr<NodeNames> names;
    NodeId id = 0;
    SharedMemory* memory = nullptr;
    Network* network = nullptr;
    std::shared_ptr<BufferPool> heap;  ///< the pool for samples that are not in shared memory
    WakeSlots& slots;
    Dispatcher& dispatcher;
    Dispatcher& poller;
    CallbackThread& callbacks;
    Agent& agent;
    // The agent's thread alone uses these two.
    Reconciler& reconciler;
    NodeLog& log;
  };
  explicit EndpointOpening(Node node) : node_(std::move(node)) {}

  NodeNames& names() const { return *node_.names; }

  struct Writer {
    Endpoint endpoint;
    std::shared_ptr<PublisherCore> core;
  };
  Result<Writer> open_writer(std::string_view topic, const TypeSupport& type,
                             const PublisherOptions& options) const;

  struct ReaderOrder {
    std::string_view topic;  ///< the topic as the program names it
    const TypeSupport& type;
    detail::untyped::Requirement requirement;
    const SubscriberOptions& options;
    detail::untyped::Callback callback;
    std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null if the type is static
    TopicName name{};                          ///< set by open_reader()
  };
  struct ReaderEndpoint {
    Endpoint endpoint;
    LocalReader::Parts parts;
  };
  struct Reader {
    std::shared_ptr<SubscriberCore> core;
    std::vector<ReaderEndpoint> endpoints;  ///< in the order of the selections
    std::uint32_t slot = 0;                 ///< the doorbell slot; must be given back to WakeSlots after the
                                            ///< reader has ended
  };
  Result<Reader> open_reader(ReaderOrder order) const;

 private:
  std::function<void()> posted(EndpointId id, void (Reconciler::*event)(EndpointId)) const;
  void log(LogLevel level, std::string text) const;
  bool may_use(TransportKind kind, TransportChoice choice) const;
  void log_renaming(const TopicName& name) const;
  void warn_of(const std::string& topic, const std::vector<std::string>& sentences) const;
  Result<void> check(std::string_view topic, const TypeSupport& type, TransportChoice choice) const;
  static Result<void> check(const SubscriberOptions& options);
  Result<Writer> open_writer(const TopicName& name, const TypeSupport& type,
                             const PublisherOptions& options) const;
  Result<Reader> open_named(ReaderOrder order) const;
  Endpoint describe(Role role, const TopicName& name, const TypeSupport& type, TransportChoice choice) const;
  Result<void> keep_ways_for_largest_sample(Endpoint& writer) const;
  Result<std::shared_ptr<NetworkWriter>> open_network(const Endpoint& writer, const TypeSupport& type,
                                                      const PublisherOptions& options,
                                                      std::shared_ptr<DeliveryBook> book) const;
  Result<std::uint32_t> take_slot(const ReaderOrder& order) const;
  void give_up(Reader reader) const;
  static Result<std::vector<Selection>> all_selections(const ReaderOrder& order);
  Endpoint describe_reader(const ReaderOrder& order, const Selection& selection, const Qos& qos,
                           std::uint32_t slot) const;
  std::shared_ptr<SubscriberCore> make_core(const std::vector<Endpoint>& endpoints, std::uint32_t slot,
                                            const std::vector<Selection>& selections, ReaderOrder& order,
                                            std::unique_ptr<PollHandle> poll_handle) const;
  Result<std::shared_ptr<NetworkReader>> open_network(const Endpoint& reader, SubscriberCore& core,
                                                      std::size_t selection) const;
  std::uint32_t memory_depth_of(const Endpoint& reader) const;

  const Node node_;
};

}  // namespace sft::core
