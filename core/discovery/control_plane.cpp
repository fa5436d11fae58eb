#include "core/discovery/control_plane.h"

#include <algorithm>
#include <tuple>
#include <variant>

#include "core/control/record_body.h"
#include "core/platform/process_limits.h"
#include "core/platform/random_id.h"

namespace sft::core {

namespace {

using Names = std::vector<std::string>;
using PlaneKey = std::tuple<std::uint32_t, std::string, std::string, Names, Names, ThreadSettings>;

/// Returns all values that must be equal for nodes to share discovery. The text of the configuration
/// contains neither the user's interfaces nor peers nor domain number, so these are added.
PlaneKey key_of_plane(const DiscoveryOptions& options, const DdsConfig& config) {
  return {options.domain,    config.text,  config.domain_on_wire,
          config.interfaces, config.peers, options.threads};
}

/// Holds the control planes of this process, as long as any node uses them.
struct OpenPlanes {
  Mutex mutex;
  std::map<PlaneKey, std::weak_ptr<ControlPlane>> by_key SFT_GUARDED_BY(mutex);
};
OpenPlanes open_planes;

constexpr const char* sockets_closed_by_the_program =
    "the program has closed the sockets of its node (closefrom() or close() in a loop): the node finds no "
    "other nodes any more, and receives nothing by UDP; close descriptors before the first node opens";

constexpr const char* way_through_firewalls =
    "; if this is said again, a firewall lets multicast of that host through and no unicast: let in all UDP "
    "of it, or name both hosts as DiscoverySettings::peers of each other (docs/operations.md, Firewalls); or "
    "this host does not reach it, or the path drops packets of 1000 bytes";

/// Returns the interfaces that may have links. Interfaces of containers come and go, so they have no link
/// unless they are listed.
Result<std::vector<HostInterface>> interfaces_that_count(const DdsConfig& config) {
  Result<std::vector<HostInterface>> interfaces = host_interfaces();
  if (interfaces && config.interfaces.empty())
    std::erase_if(*interfaces, [](const HostInterface& one) { return belongs_to_containers(one.name); });
  return interfaces;
}

}  // namespace

/// Its functions lock the mutex of the control plane, which nodes share.
class ControlPlane::OfNode final : public Discovery {
 public:
  OfNode(std::shared_ptr<ControlPlane> plane, std::function<void()> wake)
      : plane_(std::move(plane)),
        node_(plane_->ask([&](Directory& directory) { return directory.join(std::move(wake)); })) {}
  ~OfNode() override;

  Configuration configuration() const override { return plane_->configuration(); }
  std::vector<DiscoveryEvent> take_events() override {
    return plane_->ask([&](Directory& directory) { return directory.take_events(*node_); });
  }
  void hear(Role role) override;
  std::vector<KnownPublisher> publishers_of(std::string_view type_name) const override {
    return plane_->ask([&](Directory& directory) { return directory.publishers_of(type_name); });
  }
  void announce(const Endpoint& endpoint) override;
  void withdraw(EndpointId id) override;
  void send(const Request& request) override;
  void inquire(const std::set<Inquiry>& inquiries) override;
  Inquiries inquiries() const override {
    return plane_->ask([](Directory& directory) { return directory.inquiries(); });
  }
  void report(const NodeReport& report) override;
  Vanilla vanilla() const override { return plane_->known_.vanilla(); }
  Time look_after(Time now) override {
    const Lock lock(plane_->mutex_);
    return plane_->look(now);
  }

 private:
  const std::shared_ptr<ControlPlane> plane_;  ///< destroyed with the last node that uses it
  const std::shared_ptr<ListeningNode> node_;
};

Result<std::unique_ptr<Discovery>> Discovery::open(const DiscoveryOptions& options,
                                                   std::function<void()> wake) {
  Result<std::shared_ptr<ControlPlane>> plane = ControlPlane::of(options);
  if (!plane) return tl::unexpected(plane.error());
  return std::make_unique<ControlPlane::OfNode>(std::move(*plane), std::move(wake));
}

Result<std::shared_ptr<ControlPlane>> ControlPlane::of(const DiscoveryOptions& options) {
  Result<DdsConfig> config = dds_config(options.domain, options.settings, options.user_config);
  if (!config) return tl::unexpected(config.error());
  const Lock lock(open_planes.mutex);  // so that two nodes do not open the same plane twice
  std::erase_if(open_planes.by_key, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<ControlPlane>& known = open_planes.by_key[key_of_plane(options, *config)];
  if (auto plane = known.lock()) return plane;
  auto plane = std::make_shared<ControlPlane>(std::move(*config), options.threads);
  if (Result<void> opened = plane->open(); !opened) return tl::unexpected(opened.error());
  known = plane;
  return plane;
}

ControlPlane::ControlPlane(DdsConfig config, const ThreadSettings& threads)
    : config_(std::move(config)),
      process_(random_id()),
      known_(process_, timing_),
      peers_by_name_(config_.peers, threads),
      own_(process_, timing_),
      links_({config_, threads, timing_}, own_, known_) {}

Result<void> ControlPlane::open() {
  const Lock lock(mutex_);
  Result<std::vector<HostInterface>> listed = interfaces_that_count(config_);
  if (!listed) return tl::unexpected(listed.error());
  interfaces_ = std::move(*listed);
  const DesiredLinks desired = desired_links(interfaces_, config_.rules(), {});
  const Time now = std::chrono::steady_clock::now();
  look_at_interfaces_at_ = now + timing_.look_at_interfaces;
  peers_by_name_.used_on(config_.family_of_peers(desired.links));
  peers_by_name_.look_after(now);
  peers_by_name_.wait_for_answers(now + timing_.wait_for_names);
  peers_by_name_.look_after(std::chrono::steady_clock::now());
  const Result<void> made = use_interfaces(desired);
  if (!links_.empty()) return {};
  if (!made) return made;
  return fail(Errc::unavailable, "no network interface is up, not even the loopback (ip link set lo up)");
}

/// Withdraws what the node has announced.
ControlPlane::OfNode::~OfNode() {
  const Lock lock(plane_->mutex_);
  const Time now = std::chrono::steady_clock::now();
  for (const EndpointId id : plane_->ask([&](Directory& directory) { return directory.endpoints_of(node_); }))
    plane_->withdraw_records(id, now);
  plane_->ask([&](Directory& directory) { directory.leave(node_); });
  plane_->write_inquiries(now);
}

Discovery::Configuration ControlPlane::configuration() const {
  const Lock lock(configuration_mutex_);
  return configuration_;
}

void ControlPlane::OfNode::hear(Role role) {
  const Lock lock(plane_->mutex_);
  plane_->known_.with([&](Peers& peers, Directory& directory) {
    peers.listen(role, std::chrono::steady_clock::now());
    directory.hear_all(node_, role);
  });
  plane_->use_.reads_records[role] = true;
  (void)plane_->use_links();
}

/// The request is written first, because other processes use the announcement of a subscriber only together
/// with its request.
void ControlPlane::OfNode::announce(const Endpoint& endpoint) {
  const Lock lock(plane_->mutex_);
  const Time now = std::chrono::steady_clock::now();
  plane_->known_.with([&](Peers& peers, Directory& directory) {
    peers.listen(other(endpoint.role), now);
    directory.announced(node_, endpoint);
  });
  plane_->use_.reads_records[other(endpoint.role)] = true;
  (void)plane_->use_links();
  if (endpoint.role == Role::reader)
    plane_->put(endpoint.role, endpoint.id, RecordKind::request, to_bytes(endpoint.request), now);
  plane_->put(endpoint.role, endpoint.id, RecordKind::announcement, to_bytes(endpoint), now);
  plane_->give_heartbeats(now);
}

void ControlPlane::OfNode::send(const Request& request) {
  const Lock lock(plane_->mutex_);
  const Time now = std::chrono::steady_clock::now();
  if (plane_->ask([&](Directory& directory) { return directory.requested(request); }))
    plane_->put(Role::reader, request.reader, RecordKind::request, to_bytes(request), now);
  plane_->give_heartbeats(now);
}

void ControlPlane::OfNode::withdraw(EndpointId id) {
  const Lock lock(plane_->mutex_);
  const Time now = std::chrono::steady_clock::now();
  plane_->withdraw_records(id, now);
  plane_->give_heartbeats(now);
}

void ControlPlane::put(Role role, EndpointId owner, RecordKind kind, std::vector<std::byte> body, Time now) {
  const auto change = own_.put(role, owner, kind, std::move(body), now);
  if (!change) return;
  links_.each([&](ControlLink& link) { link.write(role, *change); });
}

void ControlPlane::withdraw_records(EndpointId id, Time now) {
  const auto role = ask([&](Directory& directory) { return directory.withdrawn(id); });
  if (role) withdraw_owned(*role, id, now);
}

void ControlPlane::withdraw_owned(Role role, std::uint64_t owner, Time now) {
  for (const OwnRecords::Change& change : own_.withdraw(role, owner, now))
    links_.each([&](ControlLink& link) { link.write(role, change); });
}

void ControlPlane::give_heartbeats(Time now) {
  if (!own_.is_heartbeat_due(now)) return;
  own_.heartbeat_given(now);
  links_.each([digests = own_.digests()](ControlLink& link) { link.give_heartbeat(digests); });
}

void ControlPlane::OfNode::inquire(const std::set<Inquiry>& inquiries) {
  const Lock lock(plane_->mutex_);
  const Time now = std::chrono::steady_clock::now();
  plane_->ask([&](Directory& directory) { directory.inquires(node_, inquiries); });
  plane_->write_inquiries(now);
  plane_->give_heartbeats(now);
}

/// Every inquiry is written to the topic of subscribers' records, which processes with publishers read.
/// Inquiries about accounts are for subscribers, too. So these are also written to the topic of publishers'
/// records, which processes with subscribers read.
void ControlPlane::write_inquiries(Time now) {
  const auto wanted = ask([](Directory& directory) { return directory.own_inquiries(); });
  (void)use_links();  // called first, because reports come soon
  std::erase_if(inquiries_, [&](const auto& item) SFT_NO_THREAD_SAFETY_ANALYSIS {
    const auto& [inquiry, owner] = item;
    if (wanted.contains(inquiry)) return false;
    for (const Role role : both_roles) withdraw_owned(role, owner, now);
    return true;
  });
  for (const Inquiry& inquiry : wanted) {
    const auto [owned, is_new] = inquiries_.try_emplace(inquiry, random_id());
    if (!is_new) continue;
    for (const Role role : both_roles) {
      if (role == Role::reader || inquiry.wants_accounts)
        put(role, owned->second, RecordKind::inquiry, to_bytes(inquiry), now);
    }
  }
}

/// Opens and closes readers and writers on all links as endpoints and inquiries require. If one cannot be
/// opened, try_again() warns and tries it again.
Result<void> ControlPlane::use_links() {
  std::tie(use_.reads_reports, use_.writes_reports) = ask([](Directory& directory) {
    return std::pair(!directory.own_inquiries().empty(), directory.do_others_inquire());
  });
  return links_.follow(use_);
}

void ControlPlane::OfNode::report(const NodeReport& report) {
  const Lock lock(plane_->mutex_);
  plane_->ask([&](Directory& directory) { directory.reported(node_, report); });
  (void)plane_->use_links();
  if (plane_->use_.writes_reports)
    plane_->links_.each([body = to_bytes(report)](ControlLink& link) { link.give_report(body); });
}

/// Returns the time by which look() must be called again.
Time ControlPlane::look(Time now) {
  Time next = Time::max();
  if (monitors_ && (monitor_.changed() || now >= look_at_interfaces_at_)) look_at_interfaces(now);
  if (monitors_) next = std::min(look_at_interfaces_at_, look_at_peers_by_name(now));
  links_.each([&](ControlLink& link) { link.take_heartbeats(now); });
  const KnownPeers::Todo todo = known_.look(now);
  for (const LinkAction& action : todo.of_links) act(action, now);
  (void)use_links();
  if (now >= try_again_at_) try_again(now);
  give_heartbeats(now);
  return std::min({next, todo.next, own_.heartbeat_due()});
}

/// A failure is reported only once while it lasts.
void ControlPlane::try_again(Time now) {
  try_again_at_ = now + timing_.try_again;
  Result<void> tried = links_.write_again();
  if (Result<void> used = use_links(); !used) tried = std::move(used);
  const std::string failure = tried ? "" : tried.error().message;
  if (std::exchange(failure_, failure) != failure && !tried)
    log_news(News::warning, failure + "; it is tried again until it succeeds");
}

void ControlPlane::act(const LinkAction& action, Time now) {
  using enum LinkAction::Kind;
  if (action.kind == renew) return renew_link(action, now);
  if (action.kind == end) return links_.close(action.link);
  ControlLink* const link = links_.find(action.link);
  if (link == nullptr) return;
  if (action.kind == use_topic) {
    (void)link->use_topic();
  } else {
    link->announce(action.kind == ask);
  }
}

void ControlPlane::renew_link(const LinkAction& action, Time now) {
  const std::string missing = "something is missing of what a process" +
                              (action.from.is_any() ? "" : " at " + format(action.from)) +
                              " has that heartbeats count; ";
  if (const Result<LinkSpec> made = links_.renew(action.link)) {
    log_news(News::link_renewed, "on " + made->interface + " " + missing + "the link is made anew" +
                                     (made->loopback ? "" : way_through_firewalls));
  } else {
    log_news(News::warning, missing + made.error().message);
  }
  give_heartbeats(now);
}

void ControlPlane::look_at_interfaces(Time now) {
  if (monitor_.was_closed()) return give_up();
  Result<std::vector<HostInterface>> interfaces = interfaces_that_count(config_);
  const bool is_known = interfaces.has_value();
  const bool changed = is_known && *interfaces != interfaces_;
  if (changed) {
    interfaces_ = *std::move(interfaces);
    peers_by_name_.network_changed();
    known_.with([&](Peers& peers, Directory&) { peers.network_changed(now); });
  }
  if (changed || !links_.failures().empty())
    (void)use_interfaces(desired_links(interfaces_, config_.rules(), links_.specs()));
  const bool is_well = is_known && links_.failures().empty();
  look_at_interfaces_at_ = now + (is_well ? timing_.look_at_interfaces : timing_.try_again);
}

Time ControlPlane::look_at_peers_by_name(Time now) {
  PeerAddresses::Look look = peers_by_name_.look_after(now);
  if (look.addresses_changed || look.warnings_changed)
    (void)use_interfaces(desired_links(interfaces_, config_.rules(), links_.specs()));
  for (const std::string& text : look.news) log_news(News::warning, text);
  return look.next;
}

Result<void> ControlPlane::use_interfaces(const DesiredLinks& desired) {
  const std::string before = configuration().summary;
  peers_by_name_.used_on(config_.family_of_peers(desired.links));
  Result<void> used = links_.use(desired.links, peers_by_name_.known());
  describe(desired);
  if (const std::string after = configuration().summary; after != before && !before.empty())
    log_news(News::links_changed, after);
  return used;
}

void ControlPlane::describe(const DesiredLinks& desired) {
  std::vector<LinkSpec> specs = links_.specs();
  std::ranges::stable_partition(specs, &LinkSpec::loopback);
  Discovery::Configuration present{.summary = config_.summary(specs),
                                   .warnings = config_.warnings,
                                   .remarks = desired.remarks,
                                   .waits_for_network = desired.waits_for_network};
  std::ranges::copy(links_.warnings(), std::back_inserter(present.warnings));
  std::ranges::copy(peers_by_name_.warnings(), std::back_inserter(present.warnings));
  for (const std::string& remark : desired.remarks) present.summary += "; " + remark;
  for (const std::string& failure : links_.failures()) present.summary += "; " + failure;
  if (desired.waits_for_network)
    present.summary += "; no network yet: other hosts are looked for as soon as an interface is up";
  for (const LinkSpec& spec : specs) {
    if (std::ranges::find(present.interfaces, spec.interface) == present.interfaces.end())
      present.interfaces.push_back(spec.interface);
  }
  const Lock lock(configuration_mutex_);
  configuration_ = std::move(present);
}

/// Closes the links if possible, since Cyclone's threads would keep a core busy with closed sockets. This
/// is possible only if the numbers of the closed descriptors are still unused. Otherwise Cyclone might
/// close files that the program has opened since then.
void ControlPlane::give_up() {
  monitors_ = false;
  if (has_no_open_files()) links_.close_all();
  log_news(News::warning, sockets_closed_by_the_program);
  const Lock lock(configuration_mutex_);
  configuration_ = {.summary = sockets_closed_by_the_program, .warnings = {sockets_closed_by_the_program}};
}

void ControlPlane::log_news(News news, const std::string& text) {
  ask([&](Directory& directory) { directory.log_news(news, text); });
}

}  // namespace sft::core
