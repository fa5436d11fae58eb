#include "core/discovery/link_care.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void LinkCare::made(LinkId id, Time now, bool heartbeats_find) {
  links_.insert_or_assign(id, Link{.stirred_at = now,
                                   .renewed_at = now,
                                   .repeat_until = heartbeats_find ? now : now + 2 * timing_.lease,
                                   .announce_at = now + timing_.heartbeat_every});
}

/// The new link takes over the pause, which grows while renewals do not help.
void LinkCare::replaced(LinkId id, LinkId by, Time now) {
  links_.at(by).pause = links_.at(id).pause;
  retire(id, now);
}

void LinkCare::retire(LinkId id, Time now) {
  const auto link = links_.find(id);
  if (link != links_.end() && !link->second.retired_at) link->second.retired_at = now;
}

void LinkCare::joined(LinkId id, Time now) {
  Link& link = links_.at(id);
  ++link.participants;
  link.stirred_at = now;
  link.announce_pause = {};
}

void LinkCare::left(LinkId id) { --links_.at(id).participants; }

void LinkCare::stirred(LinkId id, Time now) { links_.at(id).stirred_at = now; }

/// While other participants are being found, Cyclone will probably find the unknown participant, too. So
/// this function waits, but no longer than a lease, because new participants may keep coming.
void LinkCare::unknown_came(LinkId id, Time now) {
  Link& link = links_.at(id);
  if (!link.unknown_at || now >= *link.unknown_at + 2 * timing_.lease) link.unknown_at = now;
  if (now < std::min(link.stirred_at + 2 * timing_.settle, *link.unknown_at + timing_.lease)) return;
  link.unknown_at.reset();
  link.has_unknown = true;
}

void LinkCare::was_asked(LinkId id) { links_.at(id).was_asked = true; }

void LinkCare::network_changed(Time now) {
  for (auto& [id, link] : links_) {
    link.has_unknown = true;
    link.announce_at = now;
    link.announce_pause = {};
  }
}

void LinkCare::misses(const std::map<LinkId, bool>& links) {
  for (auto& [id, link] : links_) {
    const auto missed = links.find(id);
    link.misses = missed == links.end() ? std::nullopt : std::optional(missed->second);
  }
}

Time LinkCare::renewal_due(const Link& link) const {
  return link.renewed_at + (*link.misses ? timing_.lease : std::max(link.pause, timing_.lease));
}

Time LinkCare::missed_from(LinkId id, Time behind_since, bool was_complete) const {
  const Link& link = links_.at(id);
  const auto participants = static_cast<int>(std::min(link.participants, participants_counted_max));
  Time::duration timeout = timing_.settle + timing_.settle_each * participants;
  timeout += timeout * static_cast<int>(self_ % 64) / 128;
  const Time begin = std::max(behind_since, std::min(link.stirred_at, behind_since + timing_.lease));
  return begin + (was_complete ? timeout : 2 * timeout);
}

LinkCare::Due LinkCare::look(Time now) {
  Due due;
  for (auto& [id, link] : links_) {
    if (link.retired_at) {
      if (now >= *link.retired_at + timing_.lease) due.ends.push_back(id);
      continue;
    }
    if (link.misses && now >= renewal_due(link)) {
      due.renewals.push_back(id);
      const auto longer = *link.misses ? timing_.lease : 2 * link.pause;
      link.pause = std::clamp(longer, timing_.lease, timing_.renew_pause_max);
      link.renewed_at = now;
    } else if (!link.misses && now >= link.renewed_at + 2 * std::max(link.pause, timing_.lease)) {
      link.pause = {};
    }
    if (const auto announced = announcement(id, link, now)) due.announcements.push_back(*announced);
  }
  return due;
}

/// Returns the announcement that is due on the link. Requests of other participants are answered no more
/// often than heartbeats are sent. A participant that sends heartbeats, but was not found, is asked to
/// announce itself with growing pauses.
std::optional<LinkCare::Announcement> LinkCare::announcement(LinkId id, Link& link, Time now) const {
  const bool repeats = link.announce_at < link.repeat_until;
  if ((!link.has_unknown && !link.was_asked && !repeats) || now < link.announce_at) return std::nullopt;
  const bool asks = std::exchange(link.has_unknown, false);
  link.was_asked = false;
  const auto longer = asks || repeats ? 2 * link.announce_pause : timing_.heartbeat_every;
  link.announce_pause = std::clamp(longer, timing_.heartbeat_every, timing_.lease);
  link.announce_at = now + link.announce_pause;
  return Announcement{id, asks};
}

Time LinkCare::next() const {
  Time next = Time::max();
  for (const auto& [id, link] : links_) {
    if (link.retired_at) {
      next = std::min(next, *link.retired_at + timing_.lease);
    } else {
      if (link.misses) next = std::min(next, renewal_due(link));
      if (link.has_unknown || link.was_asked || link.announce_at < link.repeat_until)
        next = std::min(next, link.announce_at);
    }
  }
  return next;
}

}  // namespace sft::core
