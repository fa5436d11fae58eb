#include "udp_transport/multicast/offered_groups.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "udp_transport/multicast/group_membership.h"

namespace sft::udp {

bool OfferedGroups::hear(const GroupOffer& offer, const SocketAddress& from, Time now) {
  if (offer.address == 0) return take_back(offer, now), false;
  SocketAddress report_to = from;
  report_to.port = offer.port;
  const auto known =
      std::ranges::find_if(groups_, [&](const Offered& group) { return group.offer.group == offer.group; });
  if (known != groups_.end()) {
    if (known->offer != offer && !comes_again(offer)) {
      known->is_unconfirmed = true;
      return false;
    }
    const bool was_right = known->misplaced < misplaced_max && in_use(*known, now);
    if (known->offer != offer && was_right) part_from(*known);
    known->is_unconfirmed = false;
    known->misplaced = 0;
    known->offer = offer;
    known->report_to = report_to;
    known->reported_at = {};  // the writer repeats its offer because it has received no report
    if (now - known->alive_at < silence_max) return false;
    known->alive_at = now;
    return true;
  }
  if (groups_.size() < groups_max || make_room(now)) groups_.push_back({offer, report_to, now});
  return false;
}

/// Removes a group that is not in use, or that has ended. Returns false if there is no such group.
bool OfferedGroups::make_room(Time now) {
  const auto unneeded = std::ranges::find_if(
      groups_, [&](const Offered& group) { return !in_use(group, now) || is_over(group, now); });
  if (unneeded == groups_.end()) return false;
  if (in_use(*unneeded, now)) part_from(*unneeded);
  groups_.erase(unneeded);
  return true;
}

/// Returns true if the group has ended: samples of a later group have come, and no datagram of this group
/// has come for a while.
bool OfferedGroups::is_over(const Offered& group, Time now) const {
  return now - group.alive_at >= under_way_for && std::ranges::any_of(groups_, [&](const Offered& other) {
           return other.heard != 0 && other.alive_at > group.alive_at && is_before(group.offer, other.offer);
         });
}

void OfferedGroups::take_back(const GroupOffer& offer, Time now) {
  const auto is_meant = [&](const Offered& group) { return !is_before(offer, group.offer); };
  const auto is_lost = [&](const Offered& group) { return is_meant(group) && in_use(group, now); };
  if (std::ranges::any_of(groups_, is_lost) && !comes_again(offer)) return;
  for (const Offered& group : groups_) {
    if (is_lost(group)) part_from(group);
  }
  std::erase_if(groups_, is_meant);
}

void OfferedGroups::part_from(const Offered& group) {
  constexpr std::size_t partings_max = groups_max;
  if (partings_.size() == partings_max) return;
  partings_.push_back({group.report_to, {group.offer.writer, group.offer.group, group.offer.member, 0}});
  due_ = true;
}

bool OfferedGroups::comes_again(const GroupOffer& offer) {
  return offer == std::exchange(unconfirmed_, offer);
}

bool OfferedGroups::place(FirstHeader& first, Time now, const ChannelMonitor* channels) {
  const auto known = std::ranges::find_if(
      groups_, [&](const Offered& group) { return group.offer.group == first.group.group; });
  if (known == groups_.end()) return false;
  if (known->offer.channel != 0) {
    const auto present = channels == nullptr ? std::nullopt : channels->present();
    if (present && *present != known->offer.channel) {
      note(*known, true);
      return false;
    }
    const std::uint64_t ordinal = first.group.ordinal + static_cast<std::uint64_t>(known->offer.ahead);
    if (ordinal == 0 || ordinal > ordinal_max) return false;
    first.flags |= channel_follows;
    first.channel = {known->offer.channel, first.group.sequence_high, ordinal};
  }
  came(*known, first.group.ordinal, now);
  return true;
}

void OfferedGroups::hear(const GroupProbe& probe, Time now) {
  const auto known =
      std::ranges::find_if(groups_, [&](const Offered& group) { return group.offer.group == probe.group; });
  if (known != groups_.end()) came(*known, probe.ordinal, now);
}

bool OfferedGroups::knows(std::uint32_t group) const {
  return std::ranges::any_of(groups_, [&](const Offered& one) { return one.offer.group == group; });
}

void OfferedGroups::came(Offered& group, std::uint64_t ordinal, Time now) {
  group.alive_at = now;
  group.heard = std::max(group.heard, ordinal);
  // An unconfirmed group is not reported, so that the writer repeats its offer.
  if (group.is_unconfirmed) return;
  if (group.reported_at == Time{} || now - group.reported_at >= group_report_pause) {
    group.reported_at = now;
    group.due = due_ = true;
  }
}

void OfferedGroups::note(std::uint32_t group, bool misplaced) {
  const auto known =
      std::ranges::find_if(groups_, [&](const Offered& one) { return one.offer.group == group; });
  if (known != groups_.end()) note(*known, misplaced);
}

void OfferedGroups::note(Offered& group, bool misplaced) {
  group.misplaced = misplaced ? group.misplaced + 1 : 0;
  if (group.misplaced < misplaced_max) return;
  group.is_unconfirmed = true;
  if (group.misplaced % misplaced_max == 0) group.due = due_ = true;
}

void OfferedGroups::addresses(std::vector<std::uint32_t>& to) const {
  for (const Offered& group : groups_) to.push_back(group.offer.address);
}

}  // namespace sft::udp
