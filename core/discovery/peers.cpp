#include "core/discovery/peers.h"

#include <algorithm>

namespace sft::core {

namespace {

bool is_ignored(const Participant& participant) { return participant.is_own || participant.is_one_too_many; }

/// Returns true if the participant belongs to another process, and is neither ignored nor silent.
bool is_heard(const Participant& participant) {
  return participant.process && !is_ignored(participant) && !participant.is_silent;
}

struct Held {
  std::size_t records = 0, bytes = 0;
};
Held held_by(const Participant& participant) {
  const Records &writers = participant.tables.writer.records(),
                &readers = participant.tables.reader.records();
  return {writers.all().size() + readers.all().size(), writers.bytes() + readers.bytes()};
}

Time silent_at(const Participant& participant, const Timing& timing) {
  return participant.heard_at.value_or(participant.found_at) + timing.lease;
}

/// Returns when heartbeats of the participant should have come if it knows this process.
Time known_to_it_at(const Participant& participant, const Timing& timing) {
  return participant.found_at + 2 * timing.settle;
}

}  // namespace

void Peers::listen(Role role, Time now) {
  if (!listened_[role]) listened_[role] = now;
}

void Peers::link_gone(LinkId link) {
  for (auto first = participants_.lower_bound({link, {}});
       first != participants_.end() && first->first.link == link;
       first = participants_.lower_bound({link, {}}))
    participant_gone(RemoteParticipant(first->first));
  for (auto& [process, peer] : peers_) peer.link_gone(link);
  care_.gone(link);
  unheard_.erase(link);
}

void Peers::link_replaced(LinkId link, LinkId by, Time now) {
  for (auto& [process, peer] : peers_) peer.link_replaced(link, by);
  care_.replaced(link, by, now);
}

void Peers::participant_found(const RemoteParticipant& id, ProcessId process, Time now) {
  if (!care_.has(id.link)) return;
  Participant& participant = participants_[id];
  if (participant.process) return;
  participant.process = process;
  participant.found_at = now;
  participant.is_own = process == self_;
  if (!participant.is_own) admit(id, participant, now);
}

/// Adds the participant to its process, or refuses it if the process has too many participants. Each
/// heartbeat of a refused participant tries again.
void Peers::admit(const RemoteParticipant& id, Participant& participant, Time now) {
  const Peer* const peer = find(*participant.process);
  participant.is_one_too_many = peer != nullptr && peer->participants() >= limits_.participants;
  if (participant.is_one_too_many) return;
  newcomer_at_ = now;
  care_.joined(id.link, now);
  join(id, participant);
}

void Peers::participant_asks(const RemoteParticipant& id) {
  if (participants_.contains(id)) care_.was_asked(id.link);
}

void Peers::participant_gone(const RemoteParticipant& id) {
  const auto found = participants_.find(id);
  if (found == participants_.end()) return;
  Participant& participant = found->second;
  if (participant.process && !is_ignored(participant)) care_.left(id.link);
  if (is_heard(participant)) leave(id, participant);
  forget_tables(participant);
  participants_.erase(found);
}

void Peers::forget_tables(Participant& participant) {
  bytes_ -= held_by(participant).bytes;
  participant.tables = {};
  participant.has_agreed = false;
}

bool Peers::record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record,
                        Time now) {
  if (!care_.has(by.link)) return true;
  const auto [entry, is_new] = participants_.try_emplace(by);
  Participant& participant = entry->second;
  if (is_new) participant.found_at = now;
  if (is_ignored(participant)) return true;
  if (!has_room(participant, role, key, record)) {
    participant.is_cropped = true;
    return false;
  }
  RemoteTable& table = participant.tables[role];
  bytes_ -= table.records().bytes();
  table.put(key, std::move(record));
  bytes_ += table.records().bytes();
  const bool is_on_its_way = !participant.has_agreed || table.behind_since();
  if (is_heard(participant) && is_on_its_way) care_.stirred(by.link, now);
  if (is_heard(participant)) peers_.at(*participant.process).record_came(participant, role, key);
  return true;
}

bool Peers::has_room(const Participant& of, Role role, const RecordKey& key, const Record& record) const {
  const Record* const before = of.tables[role].records().find(key);
  if (before != nullptr && record.bytes() <= before->bytes()) return true;
  const Held held = held_by(of);
  return (before != nullptr || held.records < limits_.records) &&
         held.bytes + record.bytes() <= limits_.bytes && bytes_ + record.bytes() <= limits_.bytes_of_all;
}

/// A heartbeat that names another process than that of its participant is forged, and ignored. Heartbeats
/// are read once a second. If one has waited much longer, this process was held up, and newer heartbeats
/// may have been dropped because the socket's buffer was full. So the heartbeat counts as if it came now.
void Peers::heartbeat_came(LinkId link, const Heartbeat& heartbeat, Time now, Time::duration age,
                           const IpAddress& from) {
  if (heartbeat.process == self_ || !care_.has(link)) return;
  const RemoteParticipant id{link, heartbeat.participant};
  const auto found = participants_.find(id);
  if (found == participants_.end() || !found->second.process) return care_.unknown_came(link, now);
  Participant& participant = found->second;
  if (participant.is_own || participant.process != heartbeat.process) return;
  if (participant.is_one_too_many) admit(id, participant, now);
  if (participant.is_one_too_many) return;
  if (participant.is_late(timing_, now)) participant.regular_since = now;
  participant.heard_at = age < timing_.late ? now - age : now;
  if (!from.is_any()) participant.address = from;
  if (std::exchange(participant.is_silent, false)) join(id, participant);
  peers_.at(heartbeat.process).heartbeat_came(id, heartbeat.digests, now);
}

void Peers::join(const RemoteParticipant& id, Participant& participant) {
  const ProcessId process = *participant.process;
  const auto changed = [this, process](Role role, const RecordKey& key, const Record& record) {
    actions_.emplace_back(RecordChanged{process, role, key, record});
  };
  peers_.try_emplace(process, timing_, listened_, changed).first->second.join(id, participant);
}

/// The records of a process end with its last participant. PeerLost reports the end of all records at once.
void Peers::leave(const RemoteParticipant& id, const Participant& participant) {
  const auto peer = peers_.find(*participant.process);
  if (peer->second.participants() > 1) return peer->second.leave(id);
  actions_.emplace_back(PeerLost{peer->first});
  cut_.erase(peer->first);
  peers_.erase(peer);
}

/// Returns when the participant becomes suspect. A record counts as missing only if heartbeats go on by the
/// same link, because nothing arrives by a cut link. So a third heartbeat has to follow the two that
/// disagree. The second heartbeat alone may have come while the link worked for a moment that was too short
/// for records to be sent again.
Time Peers::missed_at(LinkId link, const Participant& participant) const {
  if (participant.is_suspect || participant.is_cropped) return Time::max();
  Time missed = Time::max();
  for (const Role role : both_roles) {
    const std::optional<Time> behind = participant.tables[role].behind_since();
    if (!behind || !listened_[role]) continue;
    const Time since = std::max({*behind, *listened_[role], participant.regular_since});
    if (participant.heard_at && *participant.heard_at > since)
      missed = std::min(missed, care_.missed_from(link, since, participant.has_agreed));
  }
  return missed;
}

/// Returns when heartbeats that do not arrive by UDP have to be sent through Cyclone. This is early enough
/// for two of them to come before the lease ends.
Time Peers::unheard_at(LinkId link, const Participant& participant) const {
  const bool is_told = unheard_.contains(link) || care_.is_retired(link);
  return participant.heard_at || is_told ? Time::max()
                                         : participant.found_at + (timing_.lease - timing_.late);
}

void Peers::look(Time now) {
  looked_at_ = now;
  for (auto& [id, participant] : participants_) {
    if (is_heard(participant)) look_at(id, participant, now);
  }
  look_at_room(now);
  look_at_paths(now);
  look_at_links(now);
}

/// Participants that are silent, and those that Cyclone does not find, have mostly ended. So when the
/// limit for all is nearly reached, their tables are removed. If such a participant is still alive, a renewal
/// of the link brings its records again. A renewal also brings records that were refused, once there is room
/// for them.
void Peers::look_at_room(Time now) {
  const bool is_crowded = bytes_ > limits_.bytes_of_all / 4 * 3;
  for (auto next = participants_.begin(); next != participants_.end();) {
    const auto one = next++;
    Participant& participant = one->second;
    if (!participant.process && now >= participant.found_at + timing_.lease) {
      participant_gone(RemoteParticipant(one->first));
      continue;
    }
    if (is_crowded && participant.process && !is_heard(participant)) forget_tables(participant);
    const Held held = held_by(participant);
    const bool has_few = held.records < limits_.records && held.bytes <= limits_.bytes / 4 * 3;
    if (!is_crowded && has_few) participant.is_cropped = false;
  }
}

void Peers::look_at(const RemoteParticipant& id, Participant& participant, Time now) {
  if (now >= silent_at(participant, timing_)) {
    leave(id, participant);
    participant.is_silent = true;
    for (const Role role : both_roles) participant.tables[role].expect_nothing();
    return;
  }
  if (now >= missed_at(id.link, participant)) peers_.at(*participant.process).suspect(participant);
  if (!participant.heard_at && now >= known_to_it_at(participant, timing_)) care_.was_asked(id.link);
  if (now >= unheard_at(id.link, participant)) {
    unheard_.insert(id.link);
    actions_.emplace_back(HeartbeatsMissing{id.link});
  }
}

void Peers::look_at_paths(Time now) {
  for (const auto& [process, peer] : peers_) {
    const Peer::Paths paths = peer.paths(now);
    if (paths == cut_[process]) continue;
    cut_[process] = paths;
    actions_.emplace_back(PathsCut{process, paths.cut, paths.heard});
  }
}

void Peers::look_at_links(Time now) {
  std::map<LinkId, bool> misses;
  std::map<LinkId, IpAddress> missed;
  for (const auto& [id, participant] : participants_) {
    if (!is_heard(participant) || !participant.is_suspect) continue;
    misses[id.link] |= participant.has_agreed;
    missed[id.link] = participant.address;
  }
  care_.misses(misses);
  const LinkCare::Due due = care_.look(now);
  for (const LinkId link : due.renewals) actions_.emplace_back(RenewLink{link, missed[link]});
  for (const LinkId link : due.ends) actions_.emplace_back(EndLink{link});
  for (const Announce& announcement : due.announcements) actions_.emplace_back(announcement);
}

Time Peers::next() const {
  Time next = care_.next();
  for (const auto& [id, participant] : participants_) {
    if (!is_heard(participant)) continue;
    next = std::min({next, silent_at(participant, timing_), missed_at(id.link, participant),
                     unheard_at(id.link, participant)});
    const bool may_be_cut = participant.heard_at && peers_.at(*participant.process).participants() > 1;
    const Time late_at = may_be_cut ? *participant.heard_at + timing_.late : Time::max();
    const Time known_at = participant.heard_at ? Time::max() : known_to_it_at(participant, timing_);
    if (known_at > looked_at_) next = std::min(next, known_at);
    if (late_at > looked_at_) next = std::min(next, late_at);
  }
  return next;
}

const Peer* Peers::find(ProcessId process) const {
  const auto peer = peers_.find(process);
  return peer == peers_.end() ? nullptr : &peer->second;
}

std::optional<ProcessId> Peers::process_of(const RemoteParticipant& id) const {
  const auto found = participants_.find(id);
  return found == participants_.end() || !is_heard(found->second) ? std::nullopt : found->second.process;
}

}  // namespace sft::core
