#include "core/discovery/discovery.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/discovery/dds_config.h"
#include "core/discovery/discovery_ear.h"
#include "core/discovery/greetings.h"
#include "core/discovery/link_set.h"
#include "core/discovery/own_announcements.h"
#include "core/platform/clock.h"
#include "core/platform/network_watch.h"
#include "core/sync/mutex.h"

namespace sft::core {

namespace {

constexpr std::chrono::seconds look_at_interfaces_every{1};  // although netlink tells of changes
/// Others believe a link that was made anew with the first sign of life that comes by it.
constexpr std::chrono::milliseconds assert_often_for{700};

/// Decides which links are wanted and when others are greeted, and describes all that to the user.
class LinkedDiscovery final : public Discovery {
 public:
  explicit LinkedDiscovery(DiscoveryListener& listener) : listener_(listener), ear_(listener) {}

  Result<void> open(const DiscoveryOptions& options) {
    Result<DdsConfig> config = dds_config(options.domain, options.settings, options.user_config);
    if (!config) return tl::unexpected(config.error());
    config_ = std::move(*config);
    life_signs_ = config_.multicast ? life_signs_to_all : life_signs_to_each;
    links_.emplace(LinkSet::Settings{config_, options.threads, life_signs_}, own_, ear_, listener_);
    if (program_has_opened(options.domain)) return join_the_program(options.domain);
    interfaces_ = interfaces_of_interest();
    const Result<void> made =
        use(desired_links(interfaces_, config_.rules(), {}), std::chrono::steady_clock::now());
    if (!links_->empty()) return {};
    if (!made) return made;
    return fail(Errc::unavailable, "no network interface is up, not even the loopback (ip link set lo up)");
  }

  LifeSigns life_signs() const override { return life_signs_; }
  bool is_calm(Time now) const override { return own_pace_.is_calm(now) && pace_.is_calm(now); }
  Configuration configuration() const override {
    const Lock lock(configuration_mutex_);
    return configuration_;
  }

  Result<void> hear(Role role) override { return links_->hear(role, std::chrono::steady_clock::now()); }

  Result<void> announce(const Endpoint& endpoint) override {
    Result<void> heard = hear(other(endpoint.role));
    if (!heard) return heard;
    const Endpoint& own = own_.announce(endpoint);
    own_pace_.told_news(std::chrono::steady_clock::now());
    ear_.set_own(endpoint.id, true);
    return links_->on_each([&](DiscoveryLink& link) { return link.write(own); });
  }

  void withdraw(EndpointId id) override {
    const std::optional<Role> role = own_.withdraw(id);
    if (!role) return;
    own_pace_.told_news(std::chrono::steady_clock::now());
    links_->each([&](DiscoveryLink& link) { link.dispose(id, *role); });
    ear_.set_own(id, false);
  }

  Result<void> send(const Request& request) override {
    own_.request(request);
    own_pace_.told_news(std::chrono::steady_clock::now());
    return links_->on_each([&](DiscoveryLink& link) { return link.write(request); });
  }

  void assert_liveliness(const Assertion& assertion) override {
    node_ = assertion.node;
    Assertion complete = assertion;
    complete.digest_of_writers = own_.digest(Role::writer);
    complete.digest_of_readers = own_.digest(Role::reader);
    complete.wants_signs = pace_.wants();
    links_->each([&](DiscoveryLink& link) { link.write(complete); });
  }

  void look_after(Time now, bool somebody_is_missing) override {
    if (watches_ && (watch_.changed() || now >= next_look_)) look_at_interfaces(now);
    if (ear_.take_newcomer()) greetings_.newcomer(now);
    if (greetings_.due(now, somebody_is_missing)) links_->each([](DiscoveryLink& link) { link.greet(); });
    links_->retire(now);
    if (now < asserts_often_until_) assert_liveliness({.node = node_, .writers = {}});
    if (watches_) {
      heed_complaints(now);
      mend_deaf_links(now);
    }
    ear_.report_other_releases(now);
    if (now < next_merge_) return;
    const DiscoveryEar::AfterTick after = ear_.tick(now);
    pace_ = after.signs;
    next_merge_ = now + after.pause;
  }

 private:
  /// The program's own configuration of the domain holds, and its choice of interfaces.
  Result<void> join_the_program(std::uint32_t domain) {
    watches_ = false;
    if (Result<void> joined = links_->join(domain); !joined) return joined;
    const Lock lock(configuration_mutex_);
    configuration_.summary = "as the program itself configured DDS domain " + std::to_string(domain);
    configuration_.warnings = {
        "the program opened DDS domain " + std::to_string(domain) +
        " before its first node: neither discovery settings nor CYCLONEDDS_URI are applied by SFT"};
    return {};
  }

  /// The interfaces of before, if the system cannot list them. Containers come and go: that is no reason to
  /// greet anybody.
  std::vector<HostInterface> interfaces_of_interest() const {
    std::optional<std::vector<HostInterface>> listed = host_interfaces();
    if (!listed) return interfaces_;
    std::vector<HostInterface> interfaces = std::move(*listed);
    if (config_.interfaces.empty())
      std::erase_if(interfaces, [](const HostInterface& i) { return belongs_to_containers(i.name); });
    return interfaces;
  }

  void look_at_interfaces(Time now) {
    next_look_ = now + look_at_interfaces_every;
    std::vector<HostInterface> interfaces = interfaces_of_interest();
    const bool changed = interfaces != interfaces_;
    if (!changed && links_->failures().empty()) return;
    interfaces_ = std::move(interfaces);
    if (changed) greetings_.begin(now);
    const std::string before = configuration().summary;
    (void)use(desired_links(interfaces_, config_.rules(), links_->specs()), now);
    if (const std::string after = configuration().summary; after != before) listener_.links_changed(after);
  }

  Result<void> use(const DesiredLinks& desired, Time now) {
    Result<void> used = links_->use(desired.links, now);
    describe(desired);
    return used;
  }

  void describe(const DesiredLinks& desired) {
    std::vector<LinkSpec> specs = links_->specs();
    std::ranges::stable_partition(specs, &LinkSpec::loopback);
    Configuration present{.summary = config_.summary(specs),
                          .warnings = config_.warnings,
                          .remarks = desired.remarks,
                          .waits_for_network = desired.waits_for_network};
    std::ranges::copy(links_->warnings(), std::back_inserter(present.warnings));
    for (const std::string& remark : desired.remarks) present.summary += "; " + remark;
    for (const std::string& failure : links_->failures()) present.summary += "; " + failure;
    if (desired.waits_for_network)
      present.summary += "; no network yet: other hosts are looked for as soon as an interface is up";
    for (const LinkSpec& spec : specs) {
      if (std::ranges::find(present.interfaces, spec.interface) == present.interfaces.end())
        present.interfaces.push_back(spec.interface);
    }
    const Lock lock(configuration_mutex_);
    configuration_ = std::move(present);
  }

  /// Others have heard something else in our name than we say. Nothing of that holds for a link that is made
  /// anew.
  void heed_complaints(Time now) {
    for (const auto& [id, by] : ear_.take_complaints())
      renew(id, by + " reports announcements in our name that we did not make", now);
  }

  void mend_deaf_links(Time now) {
    const DiscoveryEar::Deafness deafness = ear_.look_for_deafness(config_.participant_lease, now);
    for (const auto& [id, participants] : deafness.complaints) links_->complain(id, participants);
    for (const auto& [deaf, why] : deafness.renewals) {
      if (renew(deaf.link, why, now)) ear_.was_renewed_for(deaf);
    }
  }

  bool renew(LinkId id, const std::string& why, Time now) {
    if (!links_->renew(id, why, now)) return false;
    greetings_.begin(now);
    if (node_ != 0) asserts_often_until_ = now + assert_often_for;
    return true;
  }

  DiscoveryListener& listener_;
  DdsConfig config_;
  LifeSigns life_signs_ = life_signs_to_all;
  bool watches_ = true;  ///< interfaces and deaf links, unless the domain is the program's own
  NetworkWatch watch_;
  Greetings greetings_{std::chrono::steady_clock::now()};
  Time next_look_{};
  Time next_merge_{};
  std::vector<HostInterface> interfaces_;
  NodeId node_ = 0;  ///< ours, once it has said that it lives
  Time asserts_often_until_{};
  mutable Mutex configuration_mutex_;
  Configuration configuration_ SFT_GUARDED_BY(configuration_mutex_);

  OwnAnnouncements own_;
  SignPace own_pace_;  ///< after what this node has told itself
  SignPace pace_;      ///< after what it has heard, at the last tick
  DiscoveryEar ear_;
  std::optional<LinkSet> links_;  ///< ends first: its threads use the ear
};

}  // namespace

Result<std::unique_ptr<Discovery>> Discovery::open(const DiscoveryOptions& options,
                                                   DiscoveryListener& listener) {
  auto discovery = std::make_unique<LinkedDiscovery>(listener);
  if (Result<void> opened = discovery->open(options); !opened) return tl::unexpected(opened.error());
  return discovery;
}

}  // namespace sft::core
