#include "tools/demo/stage/stage.h"

#include <array>
#include <random>

#include "tools/demo/roles/consumers.h"
#include "tools/demo/roles/roles.h"

namespace sft::demo {

namespace {

using std::chrono::seconds;

// A role answers for the first time when its node is open.
constexpr seconds timeout{15};

struct Actor {
  const char* name;
  const char* purpose;
  double max_rate_hz;
  void (*run)(const NodePlan& plan, bool is_recorded, Channel& channel);
};

template <class Consumer>
constexpr Actor actor{Consumer::name, Consumer::purpose, Consumer::max_rate_hz, run_subscriber<Consumer>};

struct HostPlan {
  const char* name;
  bool has_publisher;
  Actor subscriber;
};

constexpr std::array host_plans{
    HostPlan{"monitor", false, actor<Health>},  HostPlan{"cockpit", false, actor<Dashboard>},
    HostPlan{"logger", false, actor<Recorder>}, HostPlan{"nav", false, actor<Localiser>},
    HostPlan{"lidar", true, actor<Detector>},
};
// The size of /dev/shm on the host of the publisher, where some samples of 6 MB come on top of what the
// daemon needs.
constexpr unsigned publishers_shared_memory_mib = 1024;
constexpr std::size_t publisher_host_number = host_plans.size() - 1;

/// Other programs of this machine may use the default domain. They rarely use one of the upper domains.
std::uint32_t random_domain() {
  std::random_device random;
  return std::uniform_int_distribution<std::uint32_t>(100, 200)(random);
}

}  // namespace

Result<std::unique_ptr<Stage>> Stage::set_up(bool arr) {
  std::unique_ptr<Stage> stage(new Stage);
  if (const Result<void> possible = try_isolation(); possible) {
    if (const Result<void> root = become_root(); !root) return tl::unexpected(root.error());
    auto network = hosts::EmulatedNetwork::create(host_plans.size());
    if (!network) return tl::unexpected(network.error());
    stage->network_ = std::move(*network);
  } else {
    stage->why_not_ = possible.error().message;
  }
  const Result<void> started = stage->start_hosts(arr);
  if (!started) return tl::unexpected(started.error());
  return stage;
}

std::vector<Role> Stage::roles_on(std::size_t number, std::uint32_t domain, bool arr) const {
  const HostPlan& host = host_plans[number];
  const auto metered = [this](const char* interface) {
    return real_hosts() ? std::optional<std::string>(interface) : std::nullopt;
  };
  const bool remote = !host.has_publisher;
  // Samples for the subscriber would come over this interface.
  const NodePlan subscriber{
      .name = host.subscriber.name,
      .domain = domain,
      .transport = remote && !real_hosts() ? TransportChoice::udp : TransportChoice::automatic,
      .interface = metered(remote ? hosts::host_interface : "lo"),
  };
  std::vector<Role> roles{
      {subscriber.name, [=](Channel& channel) { host.subscriber.run(subscriber, arr, channel); }}};
  if (host.has_publisher) {
    const NodePlan lidar{.name = "lidar", .domain = domain, .interface = metered(hosts::host_interface)};
    roles.push_back({lidar.name, [=](Channel& channel) { run_publisher(lidar, channel); }});
  }
  return roles;
}

Result<void> Stage::start_hosts(bool arr) {
  const std::uint32_t domain = real_hosts() ? 0 : random_domain();
  for (std::size_t i = 0; i < host_plans.size(); ++i) {
    const HostSettings settings{
        .network = real_hosts() ? &network_->host(i) : nullptr,
        .shared_memory_mib =
            host_plans[i].has_publisher ? publishers_shared_memory_mib : HostSettings{}.shared_memory_mib,
    };
    Result<Host> host = Host::start(settings, roles_on(i, domain, arr));
    if (!host) return tl::unexpected(host.error());
    hosts_.push_back(std::move(*host));
  }
  for (std::size_t i = 0; i < host_plans.size(); ++i) {
    const HostPlan& plan = host_plans[i];
    subscribers_.push_back({plan.subscriber.name, plan.name, plan.subscriber.purpose,
                            plan.subscriber.max_rate_hz, plan.has_publisher, &hosts_[i].channel(0)});
  }
  return {};
}

Stage::~Stage() {
  for (Host& host : hosts_) host.dismiss();  // all hosts end at the same time
}

Result<PublisherReport> Stage::ask_publisher(const Order& order, const WhileWaiting& while_waiting) {
  return demo::ask<PublisherReport>(hosts_[publisher_host_number].channel(1), "publisher", order, timeout,
                                    while_waiting);
}

Result<SubscriberReport> Stage::ask(const Subscriber& subscriber, const WhileWaiting& while_waiting) {
  return demo::ask<SubscriberReport>(*subscriber.channel, subscriber.name, {}, timeout, while_waiting);
}

}  // namespace sft::demo
