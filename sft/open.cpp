// The composition root. Only this file connects the parts of a node, and only this file reads the
// environment.
#include <cstdlib>

#include "core/discovery/dds_config.h"
#include "core/names/remapping.h"
#include "core/node/node_core.h"
#include "core/node/simulated_clock.h"
#include "core/node/vanilla_choice.h"
#include "core/platform/domain_id.h"
#include "core/platform/forked.h"
#include "core/platform/process_limits.h"
#include "core/platform/thread.h"
#include "core/vanilla/ros_discovery.h"
#include "sft/msg_text.h"
#include "sft/node.h"
#include "shm_transport/shm_transport.h"
#include "udp_transport/udp_transport.h"

namespace sft {

namespace {

/// The numbers of descriptors and threads that a node needs with a few publishers and subscribers, one
/// network interface and the loopback.
constexpr std::size_t descriptors_of_a_node = 48;
constexpr std::size_t threads_of_a_node = 16;

NodeOptions with_defaults(const NodeOptions& options, std::uint32_t domain, NodeOptions::VanillaDds vanilla,
                          NodeOptions::DdsNames dds_names, const core::Remapping& names) {
  NodeOptions result = options;
  result.domain = domain;
  result.vanilla_dds = vanilla;
  result.dds_names = dds_names;
  result.name = names.node();
  const char* config = std::getenv("CYCLONEDDS_URI");
  if (!result.cyclonedds_config) result.cyclonedds_config = config == nullptr ? "" : config;
  return result;
}

/// Opens the UDP transport. The defaults in `options` must have been replaced by actual values.
Result<std::unique_ptr<core::Network>> open_udp(const NodeOptions& options,
                                                std::shared_ptr<core::BufferPool> heap) {
  Result<std::vector<std::string>> interfaces =
      core::discovery_interfaces(*options.domain, options.discovery, *options.cyclonedds_config);
  if (!interfaces) return tl::unexpected(interfaces.error());
  udp::UdpOptions udp;
  udp.interfaces = std::move(*interfaces);
  udp.port = options.udp.port;
  udp.receive_buffer_bytes = options.udp.receive_buffer_bytes;
  udp.max_bytes_per_s = options.udp.max_bytes_per_s;
  udp.multicast = options.udp.multicast == UdpSettings::Multicast::automatic ? udp::Multicast::automatic
                                                                             : udp::Multicast::off;
  udp.receive_thread = {"udp-recv", options.threads.receiver};
  udp.send_thread = {"udp-send", options.threads.sender};
  udp.backend = options.udp.use_io_uring ? udp::Backend::automatic : udp::Backend::sockets;
  return udp::open_udp_transport(udp, std::move(heap));
}

Result<std::unique_ptr<core::SharedMemory>> open_shm(const NodeOptions& options) {
  shm::ShmOptions shm;
  shm.daemon_path = options.shm.daemon_path;
  // secure_getenv() ignores the environment if the program has more rights than the user who started it,
  // because that user controls the environment.
  const char* daemon = secure_getenv("SFT_DAEMON");
  if (shm.daemon_path.empty() && daemon != nullptr && *daemon != '\0') {
    shm.daemon_path = daemon;
    shm.daemon_named_by = "the environment variable SFT_DAEMON";
  }
  shm.start_daemon = options.shm.start_daemon;
  shm.daemon_idle_exit = options.shm.daemon_idle_exit;
  shm.daemon_users = options.shm.daemon_users;
  shm.wake_thread = {"wake", options.threads.sender};
  return shm::open_shm_transport(shm);
}

Result<std::shared_ptr<core::SimulatedClock>> open_clock(Node& node) {
  using core::SimulatedClock;
  return from_msg(SimulatedClock::type_name, SimulatedClock::type_text)
      .and_then([&](const DynamicType& type) {
        return node.subscriber(SimulatedClock::topic, type, "clock", {.depth = 1});
      })
      .map([](DynamicSubscriber&& samples) { return std::make_shared<SimulatedClock>(std::move(samples)); });
}

/// Adds the selections of SubscriberOptions::further_selections. `selection_of` parses the text of one
/// selection.
template <class SelectionOf>
Result<void> add_further(detail::untyped::Requirement& requirement, const SubscriberOptions& options,
                         SelectionOf selection_of) {
  for (const std::string& text : options.further_selections) {
    Result<Selection> selection = selection_of(text);
    if (!selection) return tl::unexpected(selection.error());
    requirement.further.push_back(std::move(*selection));
  }
  return {};
}

}  // namespace

Result<Node> Node::open(const NodeOptions& options) {
  if (core::is_forked_copy()) return fail(Errc::unavailable, core::refuses_forked_copies);
  const Result<std::uint32_t> domain = core::domain_id(options.domain, std::getenv("ROS_DOMAIN_ID"));
  if (!domain) return tl::unexpected(domain.error());
  if (const Result<void> room = core::check_room_for(descriptors_of_a_node, threads_of_a_node); !room)
    return tl::unexpected(room.error());
  if (const Result<void> settings = core::check(options.threads); !settings)
    return tl::unexpected(settings.error());
  Result<core::Remapping> names = core::Remapping::of(options, std::getenv("SFT_REMAP"));
  if (!names) return tl::unexpected(names.error());
  const auto vanilla = core::vanilla_choice(options.vanilla_dds, std::getenv("SFT_VANILLA_DDS"));
  if (!vanilla) return tl::unexpected(vanilla.error());
  const auto dds_names = core::dds_names_choice(options.dds_names, std::getenv("SFT_DDS_NAMES"));
  if (!dds_names) return tl::unexpected(dds_names.error());
  Result<core::RosDiscovery> ros =
      core::ros_discovery(std::getenv("ROS_LOCALHOST_ONLY"), std::getenv("ROS_AUTOMATIC_DISCOVERY_RANGE"),
                          std::getenv("ROS_STATIC_PEERS"));
  if (!ros) return tl::unexpected(ros.error());
  const NodeOptions resolved = with_defaults(options, *domain, *vanilla, *dds_names, *names);
  core::NodeCore::Parts parts;
  parts.names = std::move(*names);
  parts.ros = std::move(*ros);
  if (const char* distro = std::getenv("ROS_DISTRO")) parts.ros_distro = distro;
  parts.heap = core::BufferPool::make(options.udp.memory_limit_bytes);
  parts.log = core::log_setting(options, std::getenv("SFT_LOG"));
  if (options.transport != TransportChoice::shm) {
    auto udp = open_udp(resolved, parts.heap);
    if (!udp) return tl::unexpected(udp.error());
    parts.network = std::move(*udp);
  }
  if (options.transport != TransportChoice::udp) {
    auto shm = open_shm(options);
    if (!shm) return tl::unexpected(shm.error());
    parts.memory = std::move(*shm);
  }
  auto opened = core::NodeCore::open(resolved, std::move(parts));
  if (!opened) return tl::unexpected(opened.error());
  Node node(std::move(*opened));
  if (options.use_sim_time) {
    auto clock = open_clock(node);
    if (!clock) return tl::unexpected(clock.error());
    node.clock_ = std::move(*clock);
  }
  return node;
}

Result<detail::untyped::Publisher> Node::open_publisher(std::string_view topic, const TypeSupport& type,
                                                        const PublisherOptions& options) {
  return core_->open_publisher(core_, topic, type, options);
}

Result<detail::untyped::Subscriber> Node::open_subscriber(std::string_view topic, const TypeSupport& type,
                                                          Result<detail::untyped::Requirement> requirement,
                                                          const SubscriberOptions& options,
                                                          detail::untyped::Callback callback) {
  if (!requirement) return tl::unexpected(requirement.error());
  const Selection declared = requirement->selection;
  const auto selection_of = [&](std::string_view text) {
    return detail::selection_of_text(type, declared, requirement->fields_of_text, text);
  };
  if (!options.selection.empty()) {
    Result<Selection> selection = selection_of(options.selection);
    if (!selection) return tl::unexpected(selection.error());
    if (requirement->recorded && !selection->parts().empty()) {
      return fail(Errc::invalid_argument,
                  "SubscriberOptions::selection '" + options.selection +
                      "' has parts of fields, but the fields are recorded; declare them");
    }
    requirement->selection = std::move(*selection);
  }
  if (Result<void> added = add_further(*requirement, options, selection_of); !added)
    return tl::unexpected(added.error());
  return core_->open_subscriber(core_, {topic, type, std::move(*requirement), options, std::move(callback)});
}

Result<DynamicType> Node::find_type(std::string_view topic, std::chrono::nanoseconds timeout) {
  return core_->find_type(topic, timeout);
}

std::vector<TopicInfo> Node::topics() const { return core_->topics(); }

Result<DynamicSubscriber> Node::subscriber(std::string_view topic, const DynamicType& type,
                                           std::string_view fields, const SubscriberOptions& options,
                                           DynamicSubscriber::Callback callback) {
  Result<Selection> selection = type.support().parse_selection(fields);
  if (!selection) return tl::unexpected(selection.error());
  if (!options.selection.empty()) {
    return fail(
        Errc::invalid_argument,
        "'" + std::string(fields) + "' says what is needed; leave SubscriberOptions::selection empty");
  }
  detail::untyped::Requirement requirement{.selection = std::move(*selection), .limits_samples = true};
  const auto selection_of = [&](std::string_view text) { return type.support().parse_selection(text); };
  if (Result<void> added = add_further(requirement, options, selection_of); !added)
    return tl::unexpected(added.error());
  return open_subscriber(topic, type, std::move(requirement), options, std::move(callback));
}

Result<DynamicSubscriber> Node::subscriber(std::string_view topic, const DynamicType& type, detail::Recorded,
                                           const SubscriberOptions& options,
                                           DynamicSubscriber::Callback callback) {
  return open_subscriber(topic, type, {.selection = type.support().full(), .recorded = true}, options,
                         std::move(callback));
}

Result<DynamicPublisher> Node::publisher(std::string_view topic, const DynamicType& type,
                                         const PublisherOptions& options) {
  if (core::is_forked_copy()) return fail(Errc::unavailable, core::refuses_forked_copies);
  return core_->open_publisher(core_, topic, core_->kept(type), options)
      .map([&](detail::untyped::Publisher&& p) {
        return DynamicPublisher(type, std::move(p), options.max_sample_bytes);
      });
}

Result<DynamicSubscriber> Node::open_subscriber(std::string_view topic, const DynamicType& type,
                                                detail::untyped::Requirement requirement,
                                                const SubscriberOptions& options,
                                                DynamicSubscriber::Callback callback) {
  detail::untyped::Callback untyped;
  if (callback) {
    untyped = [type, callback = std::move(callback)](detail::untyped::Sample&& sample) {
      callback(DynamicSample(type, std::move(sample)));
    };
  }
  return core_
      ->open_subscriber(core_, {topic, type.support(), std::move(requirement), options, std::move(untyped),
                                std::make_shared<DynamicType>(type)})
      .map([&](detail::untyped::Subscriber&& s) { return DynamicSubscriber(type, std::move(s)); });
}

DomainSnapshot Node::domain() const { return core_->domain(); }

Result<AccountInquiry> Node::ask_accounts(std::string_view topic) const {
  return core_->ask_accounts(core_, topic);
}

void Node::interrupt() noexcept { core_->interrupt(); }

bool Node::is_interrupted() const noexcept { return core_->is_interrupted(); }

std::chrono::sys_time<std::chrono::nanoseconds> Node::now() const {
  if (clock_ == nullptr) return std::chrono::system_clock::now();
  return std::chrono::sys_time<std::chrono::nanoseconds>(clock_->now());
}

NodeStatus Node::status() const { return core_->status(); }

NodeSnapshot Node::snapshot() const { return core_->snapshot(); }

}  // namespace sft
