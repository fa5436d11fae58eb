#include "core/discovery/joint_discovery.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/discovery/dds_domain.h"
#include "core/platform/process_limits.h"

namespace sft::core {

namespace {

using Names = std::vector<std::string>;
using Key = std::tuple<std::uint32_t, std::string, std::string, Names, Names, Names, std::vector<unsigned>,
                       ThreadSettings::Policy, int, std::string>;

/// Returns all that has to be equal, so that nodes share discovery. The text of the configuration has neither
/// the user's interfaces nor the user's number of the domain.
Key key_of(const DiscoveryOptions& options, const DdsConfig& config) {
  const ThreadSettings& threads = options.threads;
  return {options.domain,    config.text,  config.domain_on_wire, config.interfaces, config.peers,
          config.user_peers, threads.cpus, threads.policy,        threads.priority,  threads.name_prefix};
}

/// Holds the discoveries of this process, as long as any node uses them.
struct OpenDiscoveries {
  Mutex mutex;
  std::map<Key, std::weak_ptr<JointDiscovery>> by_key SFT_GUARDED_BY(mutex);
};
OpenDiscoveries open_discoveries;

constexpr std::chrono::seconds look_at_interfaces_every{10};  // although netlink tells of changes
/// What the system refused: a link, or the list of interfaces.
constexpr std::chrono::seconds try_again_after{1};
/// Others believe a link that was made anew with the first sign of life that comes by it.
constexpr std::chrono::milliseconds assert_often_for{700}, assert_pause{50};
constexpr const char* closed_by_the_program =
    "the program has closed the sockets of its node (closefrom() or close() in a loop): the node finds no "
    "other nodes any more, and receives nothing by UDP; close descriptors before the first node opens";
/// The first links ask the peers by name that are looked up within this time. Other peers join later.
constexpr std::chrono::milliseconds wait_for_names{200};
/// All nodes of the process look after discovery; in that time one of them will do.
constexpr std::chrono::milliseconds one_looks_for{25};

LifeSigns life_signs_of(const DdsConfig& config) {
  if (config.pulse_port) return life_signs_by_pulses;
  return config.multicast ? life_signs_to_all : life_signs_to_each;
}

/// Returns the peers that Cyclone is given in numbers, so that this process looks up their names.
std::vector<std::string> peers_in(const DdsConfig& config) {
  std::vector<std::string> peers = config.peers;
  if (!config.text_has_user_peers)
    peers.insert(peers.end(), config.user_peers.begin(), config.user_peers.end());
  return peers;
}

/// Returns nothing if the system cannot list the interfaces. Those of containers come and go, which is no
/// reason for a greeting.
std::optional<std::vector<HostInterface>> interfaces_of_interest(const DdsConfig& config) {
  std::optional<std::vector<HostInterface>> interfaces = host_interfaces();
  if (interfaces && config.interfaces.empty())
    std::erase_if(*interfaces, [](const HostInterface& i) { return belongs_to_containers(i.name); });
  return interfaces;
}

/// Hands the report to each node of the process.
void report(const JointDiscovery::Report& report, std::list<JointDiscovery::Seat>& to) {
  for (JointDiscovery::Seat& seat : to) seat.reports.push_back(report);
}

Discovery::Configuration described(const DdsConfig& config, const LinkSet& links, const PeerAddresses& peers,
                                   const DesiredLinks& desired) {
  std::vector<LinkSpec> specs = links.specs();
  std::ranges::stable_partition(specs, &LinkSpec::loopback);
  Discovery::Configuration present{.summary = config.summary(specs),
                                   .warnings = config.warnings,
                                   .remarks = desired.remarks,
                                   .waits_for_network = desired.waits_for_network};
  std::ranges::copy(links.warnings(), std::back_inserter(present.warnings));
  std::ranges::copy(peers.warnings(), std::back_inserter(present.warnings));
  for (const std::string& remark : desired.remarks) present.summary += "; " + remark;
  for (const std::string& failure : links.failures()) present.summary += "; " + failure;
  if (desired.waits_for_network)
    present.summary += "; no network yet: other hosts are looked for as soon as an interface is up";
  for (const LinkSpec& spec : specs) {
    if (std::ranges::find(present.interfaces, spec.interface) == present.interfaces.end())
      present.interfaces.push_back(spec.interface);
  }
  return present;
}

/// By any node.
bool is_awaited(bool Discovery::Awaited::*what, const std::list<JointDiscovery::Seat>& seats) {
  return std::ranges::any_of(seats, [what](const auto& seat) { return seat.awaits.*what; });
}

/// A node's part in the discovery that it shares.
class SharedDiscovery final : public Discovery {
 public:
  SharedDiscovery(std::shared_ptr<JointDiscovery> joint, DiscoveryListener& listener)
      : joint_(std::move(joint)), seat_(joint_->join(listener)) {}
  ~SharedDiscovery() override { joint_->leave(seat_); }

  LifeSigns life_signs() const override { return joint_->life_signs(); }
  bool is_calm(Time now) const override { return joint_->is_calm(now); }
  Configuration configuration() const override { return joint_->configuration(); }
  Result<void> hear(Role role) override { return joint_->hear(seat_, role); }
  std::vector<KnownPublisher> publishers_of(std::string_view type_name) const override {
    return joint_->publishers_of(type_name);
  }
  Result<void> announce(const Endpoint& endpoint) override { return joint_->announce(seat_, endpoint); }
  void withdraw(EndpointId id) override { joint_->withdraw(id); }
  Result<void> send(const Request& request) override { return joint_->send(request); }
  void assert_liveliness(const Assertion& assertion) override { joint_->assert_liveliness(seat_, assertion); }
  Time newcomer_at() const override { return joint_->newcomers().came_at; }
  Time met_at() const override { return joint_->newcomers().met_at; }
  Time look_after(Time now, const Awaited& awaited) override {
    return joint_->look_after(seat_, now, awaited);
  }

 private:
  const std::shared_ptr<JointDiscovery> joint_;  ///< the last node ends it
  JointDiscovery::Seat& seat_;
};

}  // namespace

Result<std::unique_ptr<Discovery>> Discovery::open(const DiscoveryOptions& options,
                                                   DiscoveryListener& listener) {
  Result<std::shared_ptr<JointDiscovery>> joint = JointDiscovery::of(options);
  if (!joint) return tl::unexpected(joint.error());
  return std::make_unique<SharedDiscovery>(std::move(*joint), listener);
}

Result<std::shared_ptr<JointDiscovery>> JointDiscovery::of(const DiscoveryOptions& options) {
  Result<DdsConfig> config = dds_config(options.domain, options.settings, options.user_config);
  if (!config) return tl::unexpected(config.error());
  const Lock lock(open_discoveries.mutex);  // so that two nodes do not make the same one
  std::erase_if(open_discoveries.by_key, [](const auto& entry) { return entry.second.expired(); });
  std::weak_ptr<JointDiscovery>& known = open_discoveries.by_key[key_of(options, *config)];
  if (auto discovery = known.lock()) return discovery;
  auto discovery = std::make_shared<JointDiscovery>(std::move(*config), options.threads);
  if (Result<void> opened = discovery->open(options.domain); !opened) return tl::unexpected(opened.error());
  known = discovery;
  return discovery;
}

JointDiscovery::JointDiscovery(DdsConfig config, const ThreadSettings& threads)
    : config_(std::move(config)),
      life_signs_(life_signs_of(config_)),
      peers_(peers_in(config_), threads),
      ear_(life_signs_),
      links_({config_, threads, life_signs_}, own_, ear_) {}

Result<void> JointDiscovery::open(std::uint32_t domain) {
  const Lock lock(mutex_);
  if (program_has_opened(domain)) return join_the_program(domain);
  interfaces_ = interfaces_of_interest(config_).value_or(std::vector<HostInterface>());
  const DesiredLinks desired = desired_links(interfaces_, config_.rules(), {});
  Time now = std::chrono::steady_clock::now();
  peers_.used_on(config_.family_of_peers(desired.links));
  peers_.look_after(now);
  peers_.wait_for_answers(now + wait_for_names);
  now = std::chrono::steady_clock::now();
  peers_.look_after(now);
  const Result<void> made = use(desired, now);
  if (!links_.empty()) return {};
  if (!made) return made;
  return fail(Errc::unavailable, "no network interface is up, not even the loopback (ip link set lo up)");
}

bool JointDiscovery::is_calm(Time now) const { return now >= calm_from_.load(std::memory_order_relaxed); }

void JointDiscovery::told_news() {
  own_pace_.told_news(std::chrono::steady_clock::now());
  calm_from_ = std::max(own_pace_.calm_from(), pace_.calm_from());
}

Discovery::Configuration JointDiscovery::configuration() const {
  const Lock lock(configuration_mutex_);
  return configuration_;
}

JointDiscovery::Seat& JointDiscovery::join(DiscoveryListener& listener) {
  const Lock lock(mutex_);
  Seat& seat = seats_.emplace_back(listener);
  ear_.with_nodes([&](ProcessNodes& nodes, const auto&) { nodes.join(seat.member); });
  return seat;
}

void JointDiscovery::leave(Seat& seat) {
  const std::shared_ptr<NodeListener> member = seat.member;
  {
    const Lock lock(mutex_);
    const auto endpoints =
        ear_.with_nodes([&](ProcessNodes& nodes, const auto&) { return nodes.endpoints_of(member); });
    for (const EndpointId id : endpoints) withdraw_from_links(id);
    const NodeId node =
        ear_.with_nodes([&](ProcessNodes& nodes, const auto&) { return nodes.leave(member); });
    if (node != 0) links_.end_life(node);
    if (last_look_.by == &seat) last_look_.by = nullptr;
    seats_.remove_if([&](const Seat& one) { return &one == &seat; });
  }
  ear_.pass_on();
  member->close();
}

Result<void> JointDiscovery::hear(Seat& seat, Role role) {
  Result<void> heard;
  {
    const Lock lock(mutex_);
    ear_.with_nodes([&](ProcessNodes& nodes, const LinkMerge& merge) {
      nodes.hears_all(seat.member, role, merge.endpoints());
    });
    heard = hear_on_links(role);
  }
  ear_.pass_on();
  return heard;
}

std::vector<Discovery::KnownPublisher> JointDiscovery::publishers_of(std::string_view type_name) {
  std::vector<Discovery::KnownPublisher> publishers;
  const auto note = [&](const Endpoint& endpoint) {
    if (endpoint.role == Role::writer && endpoint.type_name == type_name)
      publishers.push_back({endpoint.topic, endpoint.node});
  };
  ear_.with_nodes([&](ProcessNodes& nodes, const LinkMerge& merge) {
    nodes.each_own(note);
    merge.endpoints().each([&](EndpointId id, const EndpointClaims&) {
      if (const Endpoint* const endpoint = merge.endpoints().told(id)) note(*endpoint);
    });
  });
  return publishers;
}

Result<void> JointDiscovery::hear_on_links(Role role) {
  ear_.hears(role, std::chrono::steady_clock::now());
  return links_.hear(role);
}

Result<void> JointDiscovery::announce(Seat& seat, const Endpoint& endpoint) {
  Result<void> written;
  {
    const Lock lock(mutex_);
    if (Result<void> heard = hear_on_links(other(endpoint.role)); !heard) return heard;
    const Endpoint& own = own_.announce(endpoint);
    told_news();
    if (endpoint.qos.liveliness_lease.count() != 0)
      links_.exchange_full_signs(std::chrono::steady_clock::now());
    ear_.with_nodes([&](ProcessNodes& nodes, LinkMerge& merge) {
      merge.owns(own.id);
      nodes.announced(seat.member, own, merge.endpoints());
    });
    written = links_.on_each([&](DiscoveryLink& link) { return link.write(own); });
  }
  ear_.pass_on();
  return written;
}

void JointDiscovery::withdraw(EndpointId id) {
  {
    const Lock lock(mutex_);
    withdraw_from_links(id);
  }
  ear_.pass_on();
}

void JointDiscovery::withdraw_from_links(EndpointId id) {
  const std::optional<Role> role = own_.withdraw(id);
  if (!role) return;
  told_news();
  links_.each([&](DiscoveryLink& link) { link.dispose(id, *role); });
  ear_.with_nodes([&](ProcessNodes& nodes, LinkMerge& merge) {
    if (const Endpoint* const own = nodes.find(id))
      merge.disowns(id, own->revision, std::chrono::steady_clock::now());
    nodes.withdrawn(id, merge.endpoints());
  });
}

Result<void> JointDiscovery::send(const Request& request) {
  Result<void> written;
  {
    const Lock lock(mutex_);
    own_.request(request);
    told_news();
    ear_.with_nodes([&](ProcessNodes& nodes, const auto&) { nodes.requested(request); });
    written = links_.on_each([&](DiscoveryLink& link) { return link.write(request); });
  }
  ear_.pass_on();
  return written;
}

void JointDiscovery::assert_liveliness(Seat& seat, const Assertion& assertion) {
  {
    const Lock lock(mutex_);
    const Time now = std::chrono::steady_clock::now();
    ear_.own_sign_given(seat.member, assertion, now);
    write(assertion, pace_.are_wanted(now), now);
  }
  ear_.pass_on();
}

/// The digests are those of all that came of our participants: of what all nodes of the process have said.
void JointDiscovery::write(Assertion assertion, bool is_wanted, Time now) {
  assertion.digest_of_writers = own_.digest(Role::writer);
  assertion.digest_of_readers = own_.digest(Role::reader);
  assertion.wants_signs = pace_.wants(now);
  links_.write(assertion, is_wanted, now);
}

Time JointDiscovery::look_after(Seat& seat, Time now, const Discovery::Awaited& awaited) {
  std::vector<Report> reports;
  Time next = Time::max();
  {
    const Lock lock(mutex_);
    seat.awaits = awaited;
    if (last_look_.by == &seat || now >= last_look_.at + one_looks_for) {
      last_look_ = {&seat, now};
      next = look_after_links(now);
    }
    reports = std::exchange(seat.reports, {});
  }
  ear_.pass_on();
  for (const Report& report : reports)
    seat.member->tell([&](DiscoveryListener& listener) { (listener.*report.tell)(report.text); });
  return next;
}

/// Returns when it has to be called again at the latest.
Time JointDiscovery::look_after_links(Time now) {
  if (watches_ && (watch_.changed() || now >= next_.look_at_interfaces)) look_at_interfaces(now);
  if (is_awaited(&Discovery::Awaited::every_sign, seats_)) ear_.tell_every_pulse();
  if (!links_.hear_pulses(now)) greetings_.stranger(now);
  ear_.pulses_heard(now);
  const HearingWatch::Newcomers newcomers = ear_.newcomers();
  greetings_.others(newcomers.participants);
  if (ear_.take_newcomer()) greetings_.newcomer(now);
  if (greetings_.due(now, is_awaited(&Discovery::Awaited::somebody, seats_)))
    links_.each([](DiscoveryLink& link) { link.greet(); });
  links_.retire(now);
  if (now < after_renewal_.until && now >= after_renewal_.next) {
    after_renewal_.next = now + assert_pause;
    const auto living = [&](const ProcessNodes& nodes, const auto&) {
      return nodes.living(now - life_signs_.pause_in_calm);
    };
    for (const NodeId node : ear_.with_nodes(living)) write({.node = node, .writers = {}}, true, now);
  }
  Time next = watches_ ? std::min(mend_links(now), look_at_peers(now)) : Time::max();
  for (std::string& renewal : links_.take_renewals())
    report({&DiscoveryListener::link_was_deaf, std::move(renewal)}, seats_);
  if (std::optional<std::string> releases = ear_.take_other_releases(now))
    report({&DiscoveryListener::warned, std::move(*releases)}, seats_);
  if (now >= next_.merge) {
    const DiscoveryEar::AfterTick after = ear_.tick(now);
    pace_ = after.signs;
    calm_from_ = std::max(own_pace_.calm_from(), pace_.calm_from());
    next_.merge = now + after.pause;
  }
  if (now < after_renewal_.until) next = std::min(next, after_renewal_.next);
  next = std::min(next, links_.exchange_due_full_signs(newcomers, now));
  return std::min(next, greetings_.next());
}

/// The program's own configuration of the domain holds, and its choice of interfaces. Nodes of other
/// processes of this host are met on the loopback all the same. If that fails, the warnings say so.
Result<void> JointDiscovery::join_the_program(std::uint32_t domain) {
  watches_ = false;
  if (Result<void> joined = links_.join(domain); !joined) return joined;
  std::vector<LinkSpec> links = links_.specs();
  std::ranges::copy_if(desired_links(interfaces_of_interest(config_).value_or(std::vector<HostInterface>()),
                                     config_.rules(), {})
                           .links,
                       std::back_inserter(links), &LinkSpec::loopback);
  const Result<void> has_loopback = links_.use(links, {}, std::chrono::steady_clock::now());
  const Lock lock(configuration_mutex_);
  configuration_.summary = "as the program itself configured DDS domain " + std::to_string(domain);
  configuration_.warnings = {
      "the program opened DDS domain " + std::to_string(domain) +
      " before its first node: discovery settings and CYCLONEDDS_URI hold only for the loopback beside it"};
  if (!has_loopback)
    configuration_.warnings.push_back("nodes of this host may not be found: " + has_loopback.error().message);
  return {};
}

/// Cyclone's threads would keep a core busy with sockets that are closed. The links only go while the numbers
/// of their descriptors are free: else Cyclone might close files that the program has opened since.
void JointDiscovery::give_up(Time now) {
  watches_ = false;
  if (has_no_open_files()) (void)links_.use({}, {}, now);
  const Lock lock(configuration_mutex_);
  configuration_ = {.summary = closed_by_the_program, .warnings = {closed_by_the_program}};
  report({&DiscoveryListener::warned, closed_by_the_program}, seats_);
}

void JointDiscovery::look_at_interfaces(Time now) {
  if (watch_.was_closed()) return give_up(now);
  std::optional<std::vector<HostInterface>> interfaces = interfaces_of_interest(config_);
  const bool is_known = interfaces.has_value();
  const bool changed = is_known && *interfaces != interfaces_;
  if (changed) interfaces_ = *std::move(interfaces);
  if (changed) greetings_.begin(now);
  if (changed) peers_.network_changed();
  if (changed || !links_.failures().empty()) use_interfaces(now);
  next_.look_at_interfaces =
      now + (is_known && links_.failures().empty() ? look_at_interfaces_every : try_again_after);
}

void JointDiscovery::use_interfaces(Time now) {
  const std::string before = configuration().summary;
  (void)use(desired_links(interfaces_, config_.rules(), links_.specs()), now);
  if (const std::string after = configuration().summary; after != before)
    report({&DiscoveryListener::links_changed, after}, seats_);
}

/// Returns when it has to be called again at the latest.
Time JointDiscovery::look_at_peers(Time now) {
  PeerAddresses::Look look = peers_.look_after(now);
  if (look.addresses_changed || look.warnings_changed) use_interfaces(now);
  if (!links_.failures().empty())
    next_.look_at_interfaces = std::min(next_.look_at_interfaces, now + try_again_after);
  if (look.addresses_changed) greet_on_new_links(now);
  for (std::string& text : look.news) report({&DiscoveryListener::warned, std::move(text)}, seats_);
  return look.next;
}

Result<void> JointDiscovery::use(const DesiredLinks& desired, Time now) {
  peers_.used_on(config_.family_of_peers(desired.links));
  Result<void> used = links_.use(desired.links, peers_.known(), now);
  const Lock lock(configuration_mutex_);
  configuration_ = described(config_, links_, peers_, desired);
  return used;
}

/// Returns when it has to be called again at the latest. Nothing of what others complain about holds for a
/// link that is made anew.
Time JointDiscovery::mend_links(Time now) {
  const DiscoveryEar::Deafness deafness = ear_.look_for_deafness(config_.participant_lease, now);
  for (const auto& [id, by] : deafness.complaints_about_us)
    renew(id, by + " reports announcements in our name that we did not make", now);
  for (const auto& [id, participants] : deafness.complaints) links_.complain(id, participants);
  for (const auto& [deaf, why] : deafness.renewals) {
    if (renew(deaf.link, why, now)) ear_.was_renewed_for(deaf);
  }
  return deafness.next_look;
}

bool JointDiscovery::renew(LinkId id, const std::string& why, Time now) {
  if (!links_.renew(id, why, now)) return false;
  greet_on_new_links(now);
  return true;
}

void JointDiscovery::greet_on_new_links(Time now) {
  greetings_.begin(now);
  after_renewal_ = {.until = now + assert_often_for, .next = now};
}

}  // namespace sft::core
