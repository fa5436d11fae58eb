#include "core/discovery/discovery.h"
#include "core/platform/clock.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <utility>

#include "core/control/control_digest.h"
#include "core/discovery/dds_config.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/discovery_link.h"
#include "core/discovery/greetings.h"
#include "core/discovery/hearing_watch.h"
#include "core/discovery/link_merge.h"
#include "core/discovery/news_desk.h"
#include "core/discovery/ordered_delivery.h"
#include "core/discovery/other_releases.h"
#include "core/discovery/participant_mark.h"
#include "core/discovery/renewal_pace.h"
#include "core/platform/network_watch.h"
#include "sft_control.h"

namespace sft::core {

namespace {

using namespace std::chrono_literals;

constexpr std::chrono::seconds look_at_interfaces_every{1};  // although netlink tells
constexpr std::chrono::milliseconds merge_every{100};
/// The old link stays so long at least, so that others find us by the new one before.
constexpr std::chrono::seconds retire_after{2}, retire_at_last_after{60};
/// Others believe a link that was made anew with the first sign of life that comes by it.
constexpr std::chrono::milliseconds assert_often_for{700};
constexpr std::size_t retiring_links_max = 2;
constexpr std::chrono::seconds farewell_max{1};

class LinkedDiscovery final : public Discovery, private LinkListener {
 public:
  explicit LinkedDiscovery(DiscoveryListener& listener) : listener_(listener) {}

  ~LinkedDiscovery() override {
    for (const auto& [spec, link] : links_) link.link->flush(farewell_max / static_cast<int>(links_.size()));
    retiring_.clear();
    links_.clear();
  }

  Result<void> open(const DiscoveryOptions& options) {
    Result<DdsConfig> config = dds_config(options.domain, options.settings, options.user_config);
    if (!config) return tl::unexpected(config.error());
    config_ = std::move(*config);
    warnings_ = config_.warnings;
    threads_ = options.threads;
    life_signs_ = config_.multicast ? life_signs_to_all : life_signs_to_each;
    if (program_has_opened(options.domain)) return join_the_program(options.domain);
    const Time now = std::chrono::steady_clock::now();
    interfaces_ = interfaces_of_interest();
    const Result<void> made = take_into_use(desired_links(interfaces_, config_.rules(), {}), now);
    describe_links();
    if (!links_.empty()) return {};
    if (!made) return made;
    return fail(Errc::unavailable, "no network interface is up, not even the loopback (ip link set lo up)");
  }

  LifeSigns life_signs() const override { return life_signs_; }
  Configuration configuration() const override {
    const std::scoped_lock lock(mutex_);
    return configuration_;
  }

  Result<void> announce(const Endpoint& endpoint) override {
    Own& own = own_[endpoint.id];
    // Greater than what somebody else has said in its name, if need be.
    const std::uint64_t revision = std::max(own.endpoint.revision + 1, endpoint.revision);
    own.endpoint = endpoint;
    own.endpoint.revision = revision;
    {
      const std::scoped_lock lock(mutex_);
      merge_.owns(endpoint.id);
    }
    return on_all([&](DiscoveryLink& link) { return link.write(own.endpoint); });
  }

  void withdraw(EndpointId id) override {
    own_.erase(id);
    each_link([&](DiscoveryLink& link) { link.dispose(id); });
    const std::scoped_lock lock(mutex_);
    merge_.disowns(id);
  }

  Result<void> send(const Request& request) override {
    if (const auto own = own_.find(request.reader); own != own_.end()) own->second.request = request;
    return on_all([&](DiscoveryLink& link) { return link.write(request); });
  }

  void assert_liveliness(const Assertion& assertion) override {
    node_ = assertion.node;
    Assertion complete = assertion;
    complete.digest = digest();
    each_link([&](DiscoveryLink& link) { link.write(complete); });
  }

  void look_after(Time now, bool somebody_is_missing) override {
    if (watches_ && (watch_.changed() || now >= next_look_)) look_at_interfaces(now);
    if (newcomer_.exchange(false)) greetings_.newcomer(now);
    if (greetings_.due(now, somebody_is_missing)) {
      each_link([](DiscoveryLink& link) { link.greet(); });
    }
    retire_links(now);
    if (now < asserts_often_until_) assert_liveliness({.node = node_, .writers = {}});
    if (watches_) {
      heed_complaints(now);
      mend_deaf_links(now);
    }
    name_other_releases(now);
    if (now < next_merge_) return;
    next_merge_ = now + merge_every;
    news([&] { merge_.tick(now); });
  }

 private:
  struct OpenLink {
    LinkId id = 0;
    std::shared_ptr<const CycloneDomain> domain;
    std::unique_ptr<DiscoveryLink> link;
  };
  struct RetiringLink {
    OpenLink link;
    LinkId replaced_by = 0;
    Time since;
  };
  /// What is in force of one of our endpoints, for links that come later.
  struct Own {
    Endpoint endpoint;
    std::optional<Request> request{};
  };

  /// Where the program itself uses the domain, its configuration holds, and its choice of interfaces.
  Result<void> join_the_program(std::uint32_t domain) {
    watches_ = false;
    auto link = DiscoveryLink::open({.link = ++links_made_, .domain = nullptr, .number = domain}, life_signs_,
                                    participants_, *this);
    if (!link) return tl::unexpected(link.error());
    links_[LinkSpec{}] = {links_made_, nullptr, std::move(*link)};
    configuration_.summary = "as the program itself configured DDS domain " + std::to_string(domain);
    configuration_.warnings = {
        "the program opened DDS domain " + std::to_string(domain) +
        " before its first node: neither discovery settings nor CYCLONEDDS_URI are applied by SFT"};
    return {};
  }

  /// Containers come and go, which is no reason to greet anybody.
  /// Those of before while the system cannot list them.
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
    if (!changed && failed_.empty()) return;
    interfaces_ = std::move(interfaces);
    if (changed) greetings_.begin(now);
    std::vector<LinkSpec> in_force;
    for (const auto& [spec, link] : links_) in_force.push_back(spec);
    (void)take_into_use(desired_links(interfaces_, config_.rules(), in_force), now);
    const std::string before = configuration().summary;
    describe_links();
    if (const std::string after = configuration().summary; after != before) listener_.links_changed(after);
  }

  /// Makes the new ones before the old ones go. The error is of the first one that could not be made; that is
  /// tried again.
  Result<void> take_into_use(const DesiredLinks& desired, Time now) {
    Result<void> result;
    failed_.clear();
    remarks_ = desired.remarks;
    waits_for_network_ = desired.waits_for_network;
    for (const LinkSpec& spec : desired.links) {
      if (links_.contains(spec)) continue;
      if (auto made = make_link(spec, nullptr)) {
        links_[spec] = std::move(*made);
      } else {
        failed_.push_back(spec.interface + ": " + made.error().message);
        if (result) result = tl::unexpected(made.error());
      }
    }
    for (auto link = links_.begin(); link != links_.end();) {
      if (std::ranges::find(desired.links, link->first) == desired.links.end()) {
        drop(std::exchange(link->second, {}), false, now);
        link = links_.erase(link);
      } else {
        ++link;
      }
    }
    return result;
  }

  void drop(OpenLink dropped, bool is_replaced, Time now) {
    dropped.link.reset();
    news([&] {
      specs_.erase(dropped.id);
      hearing_.link_dropped(dropped.id);
      is_replaced ? merge_.replaced_link_dropped(dropped.id, now) : merge_.link_dropped(dropped.id, now);
    });
  }

  /// `instead_of`: its domain is not to be used any more, or null.
  Result<OpenLink> make_link(const LinkSpec& spec, const CycloneDomain* instead_of) {
    std::vector<std::string> complaints;
    auto domain =
        cyclone_domain({config_.text_for(spec), config_.is_secured, threads_}, instead_of, complaints);
    if (!domain) return tl::unexpected(domain.error());
    const LinkId id = ++links_made_;
    {
      const std::scoped_lock lock(mutex_);
      hearing_.link_made(id);
    }
    auto link = DiscoveryLink::open({.link = id, .domain = *domain, .is_secured = config_.is_secured},
                                    life_signs_, participants_, *this);
    {
      const std::scoped_lock lock(mutex_);
      if (!link) {
        hearing_.link_dropped(id);
        return tl::unexpected(link.error());
      }
      specs_[id] = spec;
    }
    for (std::string& complaint : complaints) {
      if (std::ranges::find(warnings_, complaint) == warnings_.end())
        warnings_.push_back(std::move(complaint));
    }
    for (const auto& [endpoint, own] : own_) {
      (void)(*link)->write(own.endpoint);
      if (own.request && own.request->sequence > own.endpoint.request.sequence)
        (void)(*link)->write(*own.request);
    }
    return OpenLink{id, std::move(*domain), std::move(*link)};
  }

  /// Others have heard something else in our name than we say. To a link that is made anew nothing of that
  /// sticks.
  void heed_complaints(Time now) {
    std::map<LinkId, std::string> heard;  // and who complains
    {
      const std::scoped_lock lock(mutex_);
      for (const Speaker& by : std::exchange(complaints_, {}))
        heard.emplace(by.link, called(merge_.node_name(hearing_.node_of(by))));
    }
    for (const auto& [id, by] : heard)
      renew(id, by + " has heard something else in our name than we say", now);
  }

  void name_other_releases(Time now) {
    std::optional<OtherReleases::Report> report;
    std::string where;
    {
      const std::scoped_lock lock(mutex_);
      report = other_releases_.take_report(now);
      if (!report) return;
      const auto spec = specs_.find(report->speaker.link);
      where = spec == specs_.end() ? "the network" : spec->second.interface;
    }
    listener_.other_release_found(core::describe(*report, where, control_protocol_version()));
  }

  /// Links that do not hear somebody who is there.
  void mend_deaf_links(Time now) {
    std::vector<std::pair<HearingWatch::Deaf, std::string>> deaf;  // and whom
    std::map<LinkId, std::vector<AnnouncerId>> complaints;
    {
      const std::scoped_lock lock(mutex_);
      if (!hearing_.wants_look(now)) return;
      for (const HearingWatch::Deaf& one : hearing_.look(merge_.digests(), config_.participant_lease, now)) {
        switch (one.remedy) {
          case HearingWatch::Remedy::complaint:
            if (complaints[one.link].size() < complaints_max) complaints[one.link].push_back(one.participant);
            merge_.doubt_departures();
            break;
          case HearingWatch::Remedy::disbelief:
            merge_.disbelieve({one.link, one.participant}, now);
            break;
          case HearingWatch::Remedy::renewal:
            deaf.emplace_back(one, called(merge_.node_name(one.node)));
        }
      }
    }
    for (const auto& [id, participants] : complaints) {
      if (const auto link = link_of(id); link != links_.end()) link->second.link->complain(participants);
    }
    for (const auto& [one, whom] : deaf) {
      if (!renew(one.link, describe(one.missing, whom), now)) continue;
      const std::scoped_lock lock(mutex_);
      hearing_.tried(one.participant);
      merge_.begin_anew({one.link, one.participant});
    }
  }

  /// The new one comes before the old one goes, so that nobody is lost in between. Returns whether there is
  /// one.
  bool renew(LinkId id, const std::string& why, Time now) {
    const auto found = link_of(id);
    if (found == links_.end()) return false;
    auto& [spec, link] = *found;
    RenewalPace& pace = renewals_[spec];
    if (!pace.is_needed(now)) return false;
    pace.renewed(now);
    const std::string what = "on " + spec.interface + " " + why;
    auto made = make_link(spec, link.domain.get());
    if (!made) {
      listener_.link_was_deaf(what + "; the link cannot be made anew: " + made.error().message);
      return false;
    }
    {
      const std::scoped_lock lock(mutex_);
      specs_.erase(link.id);
      hearing_.link_replaced(link.id, made->id);
      merge_.doubt_departures();
    }
    const LinkId after = made->id;
    retiring_.push_back({std::exchange(link, std::move(*made)), after, now});
    greetings_.begin(now);
    if (node_ != 0) asserts_often_until_ = now + assert_often_for;
    listener_.link_was_deaf(what + "; the link is made anew");
    return true;
  }

  std::map<LinkSpec, OpenLink>::iterator link_of(LinkId id) {
    return std::ranges::find(links_, id, [](const auto& entry) { return entry.second.id; });
  }

  static std::string called(const std::string& node) {
    return node.empty() ? "a node" : "node '" + node + "'";
  }
  static std::string describe(HearingWatch::Missing missing, const std::string& node) {
    switch (missing) {
      case HearingWatch::Missing::signs_of_life:
        return node + " lives, but what it says of that is taken for old";
      case HearingWatch::Missing::announcements:
        return node + " has announced something else than what came";
      case HearingWatch::Missing::endpoints:
        return node + " is there, but somebody has withdrawn what it speaks or hears by";
      case HearingWatch::Missing::everything:
        return node + " is there, but nothing of it comes";
    }
    return node;
  }

  /// A replaced link is dropped once the new link hears everybody whom the old one hears, or if too many
  /// replaced links are left.
  void retire_links(Time now) {
    while (!retiring_.empty()) {
      const RetiringLink& oldest = retiring_.front();
      if (now - oldest.since < retire_after) return;
      const bool is_last_call =
          now - oldest.since >= retire_at_last_after || retiring_.size() > retiring_links_max;
      if (!is_last_call && !is_replaced(oldest, now)) return;
      OpenLink link = std::move(retiring_.front().link);
      retiring_.pop_front();
      drop(std::move(link), true, now);
    }
  }

  bool is_replaced(const RetiringLink& link, Time now) const {
    const std::scoped_lock lock(mutex_);
    return hearing_.is_replaced_by(link.link.id, link.replaced_by, now);
  }

  /// The digest of all that others should know of this node.
  std::uint32_t digest() const {
    std::uint32_t digest = 0;
    for (const auto& [id, own] : own_) {
      const std::uint64_t asked = own.request ? own.request->sequence : 0;
      digest = add_to_digest(
          digest, digest_part(id, own.endpoint.revision, std::max(asked, own.endpoint.request.sequence)));
    }
    return digest;
  }

  void describe_links() {
    std::vector<LinkSpec> specs;
    for (const auto& [spec, link] : links_) specs.push_back(spec);
    std::ranges::stable_partition(specs, &LinkSpec::loopback);
    std::string summary = config_.summary(specs);
    for (const std::string& remark : remarks_) summary += "; " + remark;
    for (const std::string& failure : failed_) summary += "; " + failure;
    if (waits_for_network_)
      summary += "; no network yet: other hosts are looked for as soon as an interface is up";
    std::vector<std::string> interfaces;
    for (const LinkSpec& spec : specs) {
      if (std::ranges::find(interfaces, spec.interface) == interfaces.end())
        interfaces.push_back(spec.interface);
    }
    const std::scoped_lock lock(mutex_);
    configuration_ = {std::move(summary), warnings_, remarks_, std::move(interfaces), waits_for_network_};
  }

  /// The first error; the others are tried all the same.
  template <class Write>
  Result<void> on_all(Write write) {
    Result<void> result;
    each_link([&](DiscoveryLink& link) {
      if (Result<void> written = write(link); !written && result) result = std::move(written);
    });
    return result;
  }
  template <class Use>
  void each_link(Use use) {
    for (const auto& [spec, link] : links_) use(*link.link);
    for (const RetiringLink& retiring : retiring_) use(*retiring.link.link);
  }

  template <class Event>
  void news(Event event) {
    const auto take = [&] {
      event();
      return merge_.take_news();
    };
    delivery_.deliver(mutex_, take, [this](const News& one) {
      const NewsDesk::Links links = has_silent_links(one) ? copy_of_specs() : NewsDesk::Links{};
      std::visit(NewsDesk(listener_, links), one);
    });
  }
  static bool has_silent_links(const News& news) {
    const auto* const seen = std::get_if<EndpointSeen>(&news);
    return seen != nullptr && !seen->silent.empty();
  }
  NewsDesk::Links copy_of_specs() const {
    const std::scoped_lock lock(mutex_);
    return specs_;
  }
  static Time time() { return std::chrono::steady_clock::now(); }

  void endpoint_came(const Speaker& speaker, Endpoint endpoint) override {
    news([&] {
      hearing_.heard(speaker, time());
      merge_.endpoint_came(speaker, std::move(endpoint), time());
    });
  }
  void endpoint_withdrawn(const Speaker& speaker, EndpointId id) override {
    news([&] { merge_.endpoint_withdrawn(speaker, id, time()); });
  }
  void endpoint_unheard(LinkId link, EndpointId id) override {
    news([&] { merge_.endpoint_unheard(link, id, time()); });
  }
  void request_came(const Speaker& speaker, Request request) override {
    news([&] {
      hearing_.heard(speaker, time());
      merge_.request_came(speaker, std::move(request), time());
    });
  }
  void assertion_came(const Speaker& speaker, Assertion assertion, std::chrono::milliseconds lease) override {
    news([&] {
      hearing_.heard_life(speaker, assertion.node, assertion.digest, lease, time());
      merge_.assertion_came(speaker, std::move(assertion), time());
    });
  }
  void node_unheard(LinkId link, NodeId id) override {
    news([&] {
      hearing_.life_ended(link, id);
      merge_.node_unheard(link, id, time());
    });
  }
  void participant_came(const Speaker& speaker) override {
    newcomer_ = true;
    const std::scoped_lock lock(mutex_);
    hearing_.participant_came(speaker, time());
  }
  void participant_speaks(const Speaker& speaker) override {
    const std::scoped_lock lock(mutex_);
    hearing_.participant_speaks(speaker, time());
  }
  void other_release_seen(const Speaker& speaker, std::uint32_t version) override {
    const std::scoped_lock lock(mutex_);
    other_releases_.seen(speaker, version);
  }
  void complaint_came(const Speaker& speaker) override {
    const std::scoped_lock lock(mutex_);
    if (complaints_.size() < complaints_max) complaints_.push_back(speaker);
  }
  void endpoint_matched(const Speaker& speaker) override {
    const std::scoped_lock lock(mutex_);
    hearing_.endpoint_matched(speaker);
  }
  void endpoint_unmatched(const Speaker& speaker) override {
    const std::scoped_lock lock(mutex_);
    hearing_.endpoint_unmatched(speaker, time());
  }
  void participant_left(const Speaker& speaker) override {
    news([&] {
      hearing_.participant_left(speaker);
      other_releases_.left(speaker);
      merge_.participant_left(speaker, time());
    });
  }
  void sample_malformed(std::string why) override { listener_.control_malformed(std::move(why)); }

  DiscoveryListener& listener_;
  DdsConfig config_;
  ThreadSettings threads_;
  LifeSigns life_signs_ = life_signs_to_all;
  bool watches_ = true;
  NetworkWatch watch_;
  Greetings greetings_{time()};
  Time next_look_{};
  Time next_merge_{};
  std::vector<HostInterface> interfaces_;
  std::map<EndpointId, Own> own_;
  NodeId node_ = 0;  ///< ours, once it has said that it lives
  Time asserts_often_until_{};
  std::vector<std::string> warnings_;
  std::vector<std::string> remarks_;
  std::vector<std::string> failed_;  ///< links that could not be made, and why
  bool waits_for_network_ = false;
  LinkId links_made_ = 0;
  std::atomic<bool> newcomer_{false};  ///< somebody was heard for the first time
  Participants participants_;

  mutable std::mutex mutex_;  ///< of what follows; Cyclone's threads come here, too
  Configuration configuration_;
  LinkMerge merge_;
  HearingWatch hearing_{std::random_device{}()};
  std::vector<Speaker> complaints_;  ///< about us
  OtherReleases other_releases_;
  NewsDesk::Links specs_;  ///< of the links
  OrderedDelivery<News> delivery_;

  std::map<LinkSpec, RenewalPace> renewals_;
  std::deque<RetiringLink> retiring_;   ///< which others still know us by; the oldest first
  std::map<LinkSpec, OpenLink> links_;  ///< goes first: its threads use the rest
};

}  // namespace

std::uint32_t control_protocol_version() { return sft_control_protocol_version; }

Result<std::unique_ptr<Discovery>> Discovery::open(const DiscoveryOptions& options,
                                                   DiscoveryListener& listener) {
  auto discovery = std::make_unique<LinkedDiscovery>(listener);
  if (Result<void> opened = discovery->open(options); !opened) return tl::unexpected(opened.error());
  return discovery;
}

}  // namespace sft::core
