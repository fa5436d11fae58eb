#include "core/discovery/discovery_ear.h"

#include <optional>
#include <random>
#include <utility>
#include <variant>

#include "core/control/control.h"
#include "core/control/control_digest.h"
#include "core/discovery/participant_mark.h"

namespace sft::core {

namespace {

bool has_silent_links(const AddressedNews& one) {
  const auto* const seen = std::get_if<EndpointSeen>(&one.news);
  return seen != nullptr && !seen->silent.empty();
}

/// Nobody can compare what it does not listen to.
template <class Sign>
std::uint32_t digest_heard(const Sign& sign, const std::set<Role>& roles) {
  return add_to_digest(roles.contains(Role::writer) ? sign.digest_of_writers : 0,
                       roles.contains(Role::reader) ? sign.digest_of_readers : 0);
}

std::string name_of_node(const ClaimedEndpoints& endpoints, NodeId node) {
  const Endpoint* const endpoint = endpoints.some_told_of(node);
  return endpoint == nullptr ? std::string() : endpoint->node;
}

std::string called(const std::string& node) { return node.empty() ? "a node" : "node '" + node + "'"; }

std::string describe(HearingWatch::Missing missing, const std::string& node) {
  switch (missing) {
    case HearingWatch::Missing::signs_of_life:
      return node + " is alive, but Cyclone discards its signs of life as old";
    case HearingWatch::Missing::announcements:
      return node + " announces other endpoints than those that arrived here";
    case HearingWatch::Missing::endpoints:
      return node + " is there, but its control endpoints were withdrawn";
    case HearingWatch::Missing::everything:
      return node + " is there, but nothing that it sends arrives";
  }
  return node;
}

}  // namespace

DiscoveryEar::DiscoveryEar(const LifeSigns& signs, ReadTime time)
    : time_(time), hearing_(std::random_device{}()), nodes_here_(signs.lease), sign_pace_(signs) {}

/// Passes on the news that have come of an event. The lock is not held meanwhile, but when this returns.
void DiscoveryEar::pass_on_news(Lock& lock) {
  nodes_here_.pass_on(merge_.take_news(), merge_.endpoints());
  delivery_.deliver(lock, nodes_here_.take(), [this](const AddressedNews& one) {
    NewsDesk::Links links;
    if (has_silent_links(one)) {
      const Lock again(mutex_);
      links = specs_;
    }
    std::visit(NewsDesk(*one.to, links), one.news);
  });
}

void DiscoveryEar::pass_on() {
  Lock lock(mutex_);
  pass_on_news(lock);
}

void DiscoveryEar::hears(Role role, Time now) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  if (roles_.insert(role).second) hearing_.hears_more(now);
}

DiscoveryEar::AfterTick DiscoveryEar::tick(Time now) {
  const Lock lock(mutex_);
  nodes_here_.tick(now);
  if (!pulses_.need_no_look(now)) {
    pulses_.tell(hearing_, merge_);
    merge_.tick(now);
    if (hearing_.is_a_sign_late(now)) sign_pace_.want_after_late_sign(now);
    if (hearing_.may_miss_something() || merge_.unrest().has_rivals) sign_pace_.want_after_doubt(now);
    pulses_.looked(now);
  }
  return {sign_pace_, merge_.pause_between_ticks()};
}

void DiscoveryEar::own_sign_given(const std::shared_ptr<NodeListener>& by, const Assertion& sign, Time now) {
  const Lock lock(mutex_);
  nodes_here_.asserted(by, sign, now);
}

bool DiscoveryEar::pulse_came(LinkId link, const Pulse& pulse, const Participants& participants, Time since) {
  const Lock lock(mutex_);
  if (nodes_here_.has(pulse.node)) return true;  // our own one; nobody else says that our node lives
  const Time now = time_();
  if (pulses_.waits(link, pulse, since, now)) return true;
  pulses_.make_way(pulse.node, pulses_.is_as_before(link, pulse), hearing_, merge_);
  const Speaker speaker{link, participants.tagged(pulse.participant).value_or(0)};
  const std::uint32_t digest = digest_heard(pulse, roles_);
  const bool counts = hearing_.heard_pulse(speaker, pulse, digest, since, now);
  if (speaker.participant != 0)
    merge_.pulse_came(speaker, counts ? std::optional(pulse.node) : std::nullopt, now);
  if (pulses_.is_steady() && !hearing_.is_steady(speaker)) pulses_.end(hearing_, merge_);
  if (counts) pulses_.told({speaker, pulse, digest}, since, now);
  return counts;
}

void DiscoveryEar::tell_every_pulse() {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
}

void DiscoveryEar::pulses_heard(Time now) {
  const Lock lock(mutex_);
  merge_.pulses_heard(now);
}

void DiscoveryEar::link_expected(LinkId link, bool hears_full_signs) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.link_made(link, hears_full_signs);
}

void DiscoveryEar::link_opened(LinkId link, const LinkSpec& spec) {
  const Lock lock(mutex_);
  specs_[link] = spec;
}

void DiscoveryEar::link_dropped(LinkId link, bool is_replaced, Time now) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  specs_.erase(link);
  hearing_.link_dropped(link);
  is_replaced ? merge_.replaced_link_dropped(link, now) : merge_.link_dropped(link, now);
}

void DiscoveryEar::link_replaced(LinkId link, LinkId by) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  specs_.erase(link);
  hearing_.link_replaced(link, by);
  merge_.doubt_departures();
}

bool DiscoveryEar::is_replaced(LinkId link, LinkId by, Time now) const {
  const Lock lock(mutex_);
  return hearing_.is_replaced_by(link, by, now);
}

std::optional<std::string> DiscoveryEar::take_other_releases(Time now) {
  const Lock lock(mutex_);
  const std::optional<OtherReleases::Report> report = other_releases_.take_report(now);
  if (!report) return std::nullopt;
  const auto spec = specs_.find(report->speaker.link);
  const std::string where = spec == specs_.end() ? "the network" : spec->second.interface;
  return core::describe(*report, where, control_protocol_version());
}

DiscoveryEar::Deafness DiscoveryEar::look_for_deafness(std::chrono::milliseconds participant_lease,
                                                       Time now) {
  Deafness deafness;
  const Lock lock(mutex_);
  if (pulses_.need_no_look(now)) {
    if (hearing_.wants_look(now)) hearing_.need_no_look(now);
    return deafness;
  }
  pulses_.tell(hearing_, merge_);
  for (const Speaker& by : std::exchange(complaints_, {}))
    deafness.complaints_about_us.emplace(by.link,
                                         called(name_of_node(merge_.endpoints(), hearing_.node_of(by))));
  std::vector<HearingWatch::Deaf> found;
  if (hearing_.wants_look(now)) {
    found = hearing_.look(merge_.digests(), participant_lease, now);
    merge_.end_what_was_lost_of(hearing_.nodes_known_whole(now));
    const bool hears_all = hearing_.is_steady() && !hearing_.is_a_sign_late(now);
    const auto unrest = hears_all ? merge_.unrest() : LinkMerge::Unrest{.is_any = true};
    if (!unrest.is_any) {
      pulses_.begin(unrest.living, hearing_.newcomers().participants, now);
    } else {
      pulses_.end(hearing_, merge_);
    }
  }
  deafness.next_look = hearing_.next_look_in_doubt();
  for (const HearingWatch::Deaf& deaf : found) {
    switch (deaf.remedy) {
      case HearingWatch::Remedy::complaint:
        if (deafness.complaints[deaf.link].size() < complaints_max)
          deafness.complaints[deaf.link].push_back(deaf.participant);
        merge_.doubt_departures();
        break;
      case HearingWatch::Remedy::disbelief:
        merge_.disbelieve({deaf.link, deaf.participant}, now);
        break;
      case HearingWatch::Remedy::renewal:
        deafness.renewals.push_back(
            {deaf, describe(deaf.missing, called(name_of_node(merge_.endpoints(), deaf.node)))});
    }
  }
  return deafness;
}

void DiscoveryEar::was_renewed_for(const HearingWatch::Deaf& deaf) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.tried(deaf.participant);
  merge_.begin_anew({deaf.link, deaf.participant});
}

void DiscoveryEar::endpoint_came(const Speaker& speaker, Endpoint endpoint) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.heard(speaker, time_(), endpoint.node_id);
  merge_.endpoint_came(speaker, std::move(endpoint), time_());
  pass_on_news(lock);
}

void DiscoveryEar::endpoint_withdrawn(const Speaker& speaker, EndpointId id) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  merge_.endpoint_withdrawn(speaker, id, time_());
  pass_on_news(lock);
}

void DiscoveryEar::endpoint_unheard(LinkId link, EndpointId id) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  merge_.endpoint_unheard(link, id, time_());
  pass_on_news(lock);
}

void DiscoveryEar::request_came(const Speaker& speaker, Request request) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.heard(speaker, time_());
  merge_.request_came(speaker, std::move(request), time_());
  pass_on_news(lock);
}

void DiscoveryEar::assertion_came(const Speaker& speaker, Assertion assertion,
                                  std::chrono::milliseconds lease) {
  Lock lock(mutex_);
  const std::uint32_t digest = digest_heard(assertion, roles_);
  const bool is_as_before = pulses_.full_sign_is_as_before(speaker, assertion.node, digest);
  pulses_.make_way(assertion.node, is_as_before, hearing_, merge_);
  hearing_.heard_life(speaker, assertion.node, digest, lease, time_());
  if (assertion.wants_signs) sign_pace_.others_want(time_());
  if (nodes_here_.has(assertion.node)) return;  // nobody else says that our node lives
  merge_.assertion_came(speaker, std::move(assertion), time_());
  pass_on_news(lock);
}

void DiscoveryEar::node_unheard(LinkId link, NodeId id) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.life_ended(link, id);
  merge_.node_unheard(link, id, time_());
  pass_on_news(lock);
}

void DiscoveryEar::participant_came(const Speaker& speaker) {
  newcomer_ = true;
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.participant_came(speaker, time_());
}

void DiscoveryEar::participant_speaks(const Speaker& speaker) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.participant_speaks(speaker, time_());
}

void DiscoveryEar::other_release_seen(const Speaker& speaker, std::uint32_t version) {
  const Lock lock(mutex_);
  other_releases_.seen(speaker, version);
}

void DiscoveryEar::complaint_came(const Speaker& speaker) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  if (complaints_.size() < complaints_max) complaints_.push_back(speaker);
}

void DiscoveryEar::endpoint_matched(const Speaker& speaker, bool is_there) {
  const Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.endpoint_matched(speaker, is_there, time_());
}

void DiscoveryEar::participant_departed(const Speaker& speaker) {
  Lock lock(mutex_);
  pulses_.end(hearing_, merge_);
  hearing_.participant_departed(speaker);
  other_releases_.departed(speaker);
  merge_.participant_departed(speaker, time_());
  pass_on_news(lock);
}

void DiscoveryEar::sample_malformed(std::string why) {
  Lock lock(mutex_);
  nodes_here_.pass_on({Refused{std::move(why)}}, merge_.endpoints());
  pass_on_news(lock);
}

}  // namespace sft::core
