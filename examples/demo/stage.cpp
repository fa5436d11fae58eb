#include "examples/demo/stage.h"

#include <array>
#include <random>

#include "examples/demo/isolation.h"
#include "examples/demo/publisher_role.h"
#include "examples/demo/subscriber_role.h"

namespace sft::demo {

namespace {

using std::chrono::seconds;

// The first answer takes until the node is open.
constexpr seconds patience{15};

struct Actor {
  const char* name;
  void (*run)(const NodePlan& plan, bool is_recorded, Channel& channel);
};

template <class Consumer>
constexpr Actor actor{Consumer::name, run_subscriber<Consumer>};

struct HostPlan {
  const char* name;
  bool has_publisher;
  Actor subscriber;
};

constexpr std::array host_plans{
    HostPlan{"monitor", false, actor<Diagnostic>},
    HostPlan{"vision", false, actor<Detector>},
    HostPlan{"mapping", false, actor<Slam>},
    HostPlan{"lidar", true, actor<Viewer>},
};
constexpr std::size_t publisher_host_number = host_plans.size() - 1;

/// On this machine others may be in the default domain; the upper ones are rarely used.
std::uint32_t random_domain() {
  std::random_device random;
  return std::uniform_int_distribution<std::uint32_t>(100, 200)(random);
}

}  // namespace

std::string_view Stage::publisher_host() { return host_plans[publisher_host_number].name; }

Result<std::unique_ptr<Stage>> Stage::set_up(CloudSource& source, bool arr) {
  std::unique_ptr<Stage> stage(new Stage);
  if (const Result<void> possible = try_isolation(); possible) {
    Result<EmulatedNetwork> network = EmulatedNetwork::create(host_plans.size());
    if (!network) return tl::unexpected(network.error());
    stage->network_ = std::move(*network);
  } else {
    stage->why_not_ = possible.error().message;
  }
  if (Result<void> started = stage->start_hosts(source, arr); !started)
    return tl::unexpected(started.error());
  return stage;
}

Result<void> Stage::start_hosts(CloudSource& source, bool arr) {
  const std::uint32_t domain = real_hosts() ? 0 : random_domain();
  const auto metered = [&](const char* interface) {
    return real_hosts() ? std::optional<std::string>(interface) : std::nullopt;
  };
  for (std::size_t i = 0; i < host_plans.size(); ++i) {
    const HostPlan& plan = host_plans[i];
    const TransportChoice transport =
        real_hosts() || plan.has_publisher ? TransportChoice::automatic : TransportChoice::udp;
    // What samples for a subscriber would come over.
    const NodePlan node{plan.subscriber.name, domain, transport,
                        metered(plan.has_publisher ? "lo" : host_interface)};
    std::vector<Role> roles{
        {plan.subscriber.name, [=](Channel& channel) { plan.subscriber.run(node, arr, channel); }}};
    if (plan.has_publisher) {
      const NodePlan lidar{"lidar", domain, TransportChoice::automatic, metered(host_interface)};
      roles.push_back({"lidar", [=, &source](Channel& channel) { run_publisher(lidar, source, channel); }});
    }
    Result<Host> host = Host::start(real_hosts() ? &network_->host(i) : nullptr, roles);
    if (!host) return tl::unexpected(host.error());
    hosts_.push_back(std::move(*host));
  }
  for (std::size_t i = 0; i < host_plans.size(); ++i) {
    const HostPlan& plan = host_plans[i];
    subscribers_.push_back({plan.subscriber.name, plan.name, plan.has_publisher, &hosts_[i].channel(0)});
  }
  return {};
}

Stage::~Stage() {
  for (Host& host : hosts_) host.dismiss();  // all of them, before any is waited for
}

Result<PublisherReport> Stage::ask_publisher(const Order& order) {
  return demo::ask<PublisherReport>(hosts_[publisher_host_number].channel(1), "publisher", order, patience);
}

Result<SubscriberReport> Stage::ask(const Subscriber& subscriber) {
  return demo::ask<SubscriberReport>(*subscriber.channel, subscriber.name, {}, patience);
}

}  // namespace sft::demo
