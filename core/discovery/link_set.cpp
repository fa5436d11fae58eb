#include "core/discovery/link_set.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/platform/hold_up_watch.h"

namespace sft::core {

namespace {
/// A replaced link stays so long at least, so that others find us by the new one before.
constexpr std::chrono::seconds retire_after{2}, retire_at_last_after{60};
constexpr std::size_t retiring_links_max = 2;
constexpr std::chrono::seconds farewell_max{1};
/// If full signs of life cannot be exchanged, and the link cannot be made anew yet.
constexpr std::chrono::seconds exchange_again_after{1};

std::optional<PulseSocket::Place> pulses_on(const LinkSpec& link, const DdsConfig& config) {
  if (!config.pulse_port || !link.ip.is_ipv4()) return std::nullopt;
  return PulseSocket::Place{.ip = link.ip,
                            .index = link.index,
                            .port = *config.pulse_port,
                            .reaches_own_host = link.loopback || link.reaches_own_host};
}
}  // namespace

LinkSet::~LinkSet() {
  for (const auto& [spec, link] : links_) link.link->flush(farewell_max / static_cast<int>(links_.size()));
  retiring_.clear();
  links_.clear();
}

Result<void> LinkSet::join(std::uint32_t domain) {
  auto link = DiscoveryLink::open({.link = ++links_made_, .domain = nullptr, .number = domain},
                                  settings_.life_signs, participants_, ear_);
  if (!link) return tl::unexpected(link.error());
  if (Result<void> exchanged = (*link)->exchange_full_signs(); !exchanged) return exchanged;
  links_[LinkSpec{}] = {links_made_, {}, nullptr, std::move(*link)};
  return {};
}

Result<void> LinkSet::use(const std::vector<LinkSpec>& wanted, const KnownHosts& hosts, Time now) {
  Result<void> result;
  hosts_ = hosts;
  open_missing(wanted, result, now);
  for (auto link = links_.begin(); link != links_.end();) {
    if (std::ranges::find(wanted, link->first) == wanted.end()) {
      drop(std::exchange(link->second, {}), false, now);
      link = links_.erase(link);
    } else {
      ++link;
    }
  }
  return result;
}

void LinkSet::open_missing(const std::vector<LinkSpec>& wanted, Result<void>& result, Time now) {
  failures_.clear();
  for (const LinkSpec& spec : wanted) {
    const auto open = links_.find(spec);
    OpenLink* const present = open == links_.end() ? nullptr : &open->second;
    const bool is_the_programs = present != nullptr && present->domain == nullptr;
    if (is_the_programs || (present != nullptr && present->config == settings_.config.text_for(spec, hosts_)))
      continue;
    if (auto made = make(spec, present)) {
      present != nullptr ? replace(*present, std::move(*made), now)
                         : static_cast<void>(links_.emplace(spec, std::move(*made)));
    } else {
      failures_.push_back(spec.interface + ": " + made.error().message);
      if (result) result = tl::unexpected(made.error());
    }
  }
}

void LinkSet::drop(OpenLink dropped, bool is_replaced, Time now) {
  next_piece_of_work();
  dropped.link.reset();
  ear_.link_dropped(dropped.id, is_replaced, now);
}

/// `instead_of` is the link that the new one replaces, or null. Its domain must not be used again.
Result<LinkSet::OpenLink> LinkSet::make(const LinkSpec& spec, const OpenLink* instead_of) {
  next_piece_of_work();
  const DdsConfig& config = settings_.config;
  std::string text = config.text_for(spec, hosts_);
  std::vector<std::string> complaints;
  auto domain = cyclone_domain({text, config.is_secured, settings_.threads},
                               instead_of == nullptr ? nullptr : instead_of->domain.get(), complaints);
  if (!domain) return tl::unexpected(domain.error());
  const LinkId id = ++links_made_;
  const auto pulses = pulses_on(spec, config);
  // Others believe a link in place of another one by the first full sign that comes by it.
  const bool waits = pulses && instead_of == nullptr;
  ear_.link_expected(id, !waits);
  auto link =
      DiscoveryLink::open({.link = id, .domain = *domain, .is_secured = config.is_secured, .pulses = pulses},
                          settings_.life_signs, participants_, ear_);
  Result<void> opened = link.map([](const auto&) {});
  if (opened && !waits) opened = (*link)->exchange_full_signs();
  for (const Role role : heard_) {
    if (opened) opened = (*link)->hear(role);
  }
  if (!opened) {
    if (link) link->reset();
    ear_.link_dropped(id, false, std::chrono::steady_clock::now());
    return tl::unexpected(opened.error());
  }
  ear_.link_opened(id, spec);
  for (std::string& complaint : complaints) {
    const auto is_known_from = [&](const auto& texts) {
      return std::ranges::find(texts, complaint) != texts.end();
    };
    if (!is_known_from(config.warnings) && !is_known_from(warnings_))
      warnings_.push_back(std::move(complaint));
  }
  own_.write_to(**link);
  OpenLink made{id, std::move(text), std::move(*domain), std::move(*link)};
  if (waits) made.waits_since = std::chrono::steady_clock::now();
  return made;
}

/// The new link comes before the old one goes, so that nobody is lost in between.
void LinkSet::replace(OpenLink& link, OpenLink successor, Time now) {
  ear_.link_replaced(link.id, successor.id);
  const LinkId after = successor.id;
  retiring_.push_back({std::exchange(link, std::move(successor)), after, now});
}

bool LinkSet::renew(LinkId id, const std::string& why, Time now) {
  const auto found = find(id);
  if (found == links_.end()) return false;
  auto& [spec, link] = *found;
  RenewalPace& pace = renewals_[spec];
  if (!pace.is_needed(now)) return false;
  pace.renewed(now);
  const std::string what = "on " + spec.interface + " " + why;
  auto made = make(spec, &link);
  if (!made) {
    told_renewals_.push_back(what + "; the link cannot be made anew: " + made.error().message);
    return false;
  }
  replace(link, std::move(*made), now);
  told_renewals_.push_back(what + "; the link is made anew");
  return true;
}

Result<void> LinkSet::hear(Role role) {
  heard_.insert(role);
  return on_each([role](DiscoveryLink& link) { return link.hear(role); });
}

std::map<LinkSpec, LinkSet::OpenLink>::iterator LinkSet::find(LinkId id) {
  return std::ranges::find(links_, id, [](const auto& entry) { return entry.second.id; });
}

template <class IsDue>
void LinkSet::exchange_full_signs_if(IsDue is_due, Time now) {
  std::map<LinkId, std::string> failed;
  for (auto& [spec, link] : links_) {
    if (!link.waits_since || !is_due(*link.waits_since)) continue;
    if (const Result<void> done = link.link->exchange_full_signs(); !done) {
      failed.emplace(link.id, "signs of life cannot be exchanged: " + done.error().message);
      continue;
    }
    link.waits_since.reset();
    ear_.link_expected(link.id, true);
    full_signs_.begin_anew();
  }
  for (const auto& [link, why] : failed) renew(link, why, now);
}

void LinkSet::exchange_full_signs(Time now) {
  exchange_full_signs_if([](Time) { return true; }, now);
}

Time LinkSet::exchange_due_full_signs(const HearingWatch::Newcomers& newcomers, Time now) {
  const auto waits = [](const auto& entry) { return entry.second.waits_since.has_value(); };
  if (std::ranges::none_of(links_, waits)) return Time::max();
  const auto due_at = [&](Time waits_since) {
    return full_signs_begin_at(waits_since, std::max(newcomers.came_at, newcomers.met_at),
                               newcomers.participants);
  };
  exchange_full_signs_if([&](Time waits_since) { return now >= due_at(waits_since); }, now);
  Time next = Time::max();
  for (const auto& [spec, link] : links_) {
    if (!link.waits_since) continue;
    const Time due = due_at(*link.waits_since);
    next = std::min(next, due > now ? due : now + exchange_again_after);
  }
  return next;
}

void LinkSet::write(const Assertion& sign, bool is_wanted, Time now) {
  if (sign.tells_more_than_life()) exchange_full_signs(now);
  const bool is_full = full_signs_.is_due(sign, is_wanted, ear_.newcomers().met_at, now);
  each([&](DiscoveryLink& link) { link.write(sign, is_full); });
}

void LinkSet::end_life(NodeId node) {
  each([node](DiscoveryLink& link) { link.end_life(node); });
  full_signs_.forget(node);
}

bool LinkSet::hear_pulses(Time now) {
  const Time since = std::exchange(heard_pulses_at_, now);
  bool all_count = true;
  each([&](DiscoveryLink& link) { all_count &= link.hear_pulses(since); });
  return all_count;
}

/// A replaced link is closed once the new link hears everybody whom the old one hears, or if there are too
/// many replaced links.
void LinkSet::retire(Time now) {
  while (!retiring_.empty()) {
    const RetiringLink& oldest = retiring_.front();
    if (now - oldest.since < retire_after) return;
    const bool is_last_call =
        now - oldest.since >= retire_at_last_after || retiring_.size() > retiring_links_max;
    if (!is_last_call && !ear_.is_replaced(oldest.link.id, oldest.replaced_by, now)) return;
    OpenLink link = std::move(retiring_.front().link);
    retiring_.pop_front();
    drop(std::move(link), true, now);
  }
}

void LinkSet::complain(LinkId id, const std::vector<AnnouncerId>& participants) {
  if (const auto link = find(id); link != links_.end()) link->second.link->complain(participants);
}

std::vector<LinkSpec> LinkSet::specs() const {
  std::vector<LinkSpec> specs;
  for (const auto& [spec, link] : links_) specs.push_back(spec);
  return specs;
}

}  // namespace sft::core
