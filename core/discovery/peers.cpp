#include "core/discovery/peers.h"

#include <algorithm>
#include <iterator>

namespace sft::core {

namespace {

bool is_heard(const Participant& participant) { return participant.process && !participant.is_silent; }

bool is_late(const Participant& participant, const Timing& timing, Time now) {
  return now - participant.heard_at.value_or(participant.found_at) >= timing.late;
}

Time silent_at(const Participant& participant, const Timing& timing) {
  return participant.heard_at.value_or(participant.found_at) + timing.lease;
}

/// Returns when heartbeats of the participant should have come if it knows this process.
Time known_to_it_at(const Participant& participant, const Timing& timing) {
  return participant.found_at + 2 * timing.settle;
}

struct Held {
  std::size_t records = 0, bytes = 0;
};
Held held_by(const Participant& participant) {
  const Records &writers = participant.tables.writer.records(),
                &readers = participant.tables.reader.records();
  return {writers.all().size() + readers.all().size(), writers.bytes() + readers.bytes()};
}

/// Returns the participants whose records count: those with the greatest rank (peers.h).
std::vector<const Participant*> counting(const Peer& peer) {
  std::vector<const Participant*> counting;
  int greatest = 1;
  for (const auto* const member : peer.participants) {
    const Participant& one = member->second;
    const int rank = one.has_agreed ? (one.is_suspect ? 2 : 3) : member == peer.participants.front() ? 1 : 0;
    if (rank < greatest) continue;
    if (rank > greatest) counting.clear();
    greatest = rank;
    counting.push_back(&one);
  }
  return counting;
}

/// Returns the record of that key with the greatest revision; null if there is none.
const Record* newest(const std::vector<const Participant*>& among, Role role, const RecordKey& key) {
  const Record* newest = nullptr;
  for (const Participant* const one : among) {
    const Record* const record = one->tables[role].records().find(key);
    if (record != nullptr && (newest == nullptr || record->revision > newest->revision)) newest = record;
  }
  return newest;
}

/// Notes that the tables match the digests of the process. Empty tables prove nothing, so they do not count
/// as agreement. Returns true if the set of participants that count has changed.
bool note_as_complete(Participant& participant) {
  const bool was_suspect = std::exchange(participant.is_suspect, false);
  const bool has_any = held_by(participant).records > 0;
  const bool is_new = has_any && !std::exchange(participant.has_agreed, true);
  return was_suspect || is_new;
}

/// Returns true if the heartbeats of this participant count. Only those of one participant do. It is the
/// first participant that is not late and either has agreed or is the first of all. If there is none, it is
/// the first participant that is not late.
bool speaks_for_all(const Peer& peer, const RemoteParticipant& id, const Timing& timing, Time now) {
  const auto is_in_time = [&](const auto* one) { return !is_late(one->second, timing, now); };
  const auto may_speak = [&](const auto* one) {
    return is_in_time(one) && (one->second.has_agreed || one == peer.participants.front());
  };
  auto speaker = std::ranges::find_if(peer.participants, may_speak);
  if (speaker == peer.participants.end()) speaker = std::ranges::find_if(peer.participants, is_in_time);
  return speaker != peer.participants.end() && (*speaker)->first == id;
}

/// The process may have several participants on a link, since it makes its own links anew. A participant
/// without heartbeats decides nothing until it counts as silent, because a firewall may let only Cyclone's
/// datagrams pass.
PathsCut cut_paths(const Peer& peer, const Timing& timing, Time now) {
  const PathsCut none{.process = peer.process};
  if (peer.links.size() < 2) return none;
  std::set<LinkId> in_time, unknown;
  for (const auto* const one : peer.participants) {
    if (!one->second.heard_at)
      unknown.insert(one->first.link);
    else if (!is_late(one->second, timing, now))
      in_time.insert(one->first.link);
  }
  PathsCut cut{.process = peer.process, .heard = {in_time.begin(), in_time.end()}};
  std::ranges::copy_if(peer.links, std::back_inserter(cut.links),
                       [&](LinkId link) { return !in_time.contains(link) && !unknown.contains(link); });
  return cut.links.empty() || cut.heard.empty() ? none : cut;
}

}  // namespace

void Peers::listen(Role role, Time now) {
  if (!listened_[role]) listened_[role] = now;
}

void Peers::link_made(LinkId link, Time now, bool heartbeats_find) {
  links_.insert_or_assign(link, Link{.stirred_at = now,
                                     .renewed_at = now,
                                     .pause = timing_.lease,
                                     .repeat_until = heartbeats_find ? now : now + 2 * timing_.lease,
                                     .announce_at = now + timing_.heartbeat_every});
}

/// The new link takes over the pause, which grows while renewals do not help.
void Peers::link_replaced(LinkId link, LinkId by, Time now) {
  for (auto& [process, peer] : peers_) {
    if (peer.links.contains(link)) peer.links.insert(by);
  }
  links_.at(by).pause = links_.at(link).pause;
  link_retired(link, now);
}

void Peers::link_retired(LinkId link, Time now) {
  const auto retired = links_.find(link);
  if (retired != links_.end() && !retired->second.retired_at) retired->second.retired_at = now;
}

void Peers::link_gone(LinkId link) {
  for (auto first = participants_.lower_bound({link, {}});
       first != participants_.end() && first->first.link == link;
       first = participants_.lower_bound({link, {}}))
    participant_gone(RemoteParticipant(first->first));
  for (auto& [process, peer] : peers_) peer.links.erase(link);
  links_.erase(link);
}

void Peers::network_changed(Time now) {
  for (auto& [id, link] : links_) {
    link.has_unknown = true;
    link.announce_at = now;
    link.announce_pause = {};
  }
}

/// A participant whose user data name this process is ignored.
void Peers::participant_found(const RemoteParticipant& id, ProcessId process, Time now, bool asks) {
  const auto link = links_.find(id.link);
  if (link == links_.end() || process == self_) return;
  const auto member = participants_.try_emplace(id).first;
  Participant& participant = member->second;
  if (participant.process) {
    link->second.was_asked |= asks;
    return;
  }
  participant.process = process;
  participant.found_at = now;
  ++link->second.participants;
  link->second.stirred_at = now;
  link->second.announce_pause = {};
  join(*member);
}

void Peers::participant_gone(const RemoteParticipant& id) {
  const auto found = participants_.find(id);
  if (found == participants_.end()) return;
  Participant& participant = found->second;
  if (participant.process) --links_.at(id.link).participants;
  if (is_heard(participant)) leave(id, *participant.process);
  forget_tables(participant);
  participants_.erase(found);
}

void Peers::join(Participants::value_type& member) {
  auto& [id, participant] = member;
  Peer& peer = peers_[*participant.process];
  peer.process = peer.cut.process = *participant.process;
  peer.participants.push_back(&member);
  peer.links.insert(id.link);
  if (is_complete(peer, participant)) note_as_complete(participant);
  refresh_all(peer);
}

/// The records of a process end with its last participant. PeerLost reports the end of all records at once.
/// Otherwise participants that have agreed move to the front, so that no participant that has never agreed
/// becomes the first.
void Peers::leave(const RemoteParticipant& id, ProcessId process) {
  Peer& peer = peers_.at(process);
  std::erase_if(peer.participants, [&](const auto* one) { return one->first == id; });
  if (peer.participants.empty()) {
    actions_.emplace_back(PeerLost{process});
    peers_.erase(process);
    return;
  }
  std::ranges::stable_partition(peer.participants, [](const auto* one) { return one->second.has_agreed; });
  refresh_all(peer);
}

void Peers::forget_tables(Participant& participant) {
  bytes_ -= held_by(participant).bytes;
  participant.tables = {};
  participant.has_agreed = false;
}

bool Peers::record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record,
                        Time now) {
  const auto link = links_.find(by.link);
  if (link == links_.end()) return true;
  const auto [entry, is_new] = participants_.try_emplace(by);
  Participant& participant = entry->second;
  if (is_new) participant.found_at = now;
  if (!has_room(participant, role, key, record)) {
    participant.is_cropped = true;
    return false;
  }
  RemoteTable& table = participant.tables[role];
  bytes_ -= table.records().bytes();
  table.put(key, std::move(record));
  bytes_ += table.records().bytes();
  if (!is_heard(participant)) return true;
  if (!participant.has_agreed || table.behind_since()) link->second.stirred_at = now;
  Peer& peer = peers_.at(*participant.process);
  if (is_complete(peer, participant) && note_as_complete(participant)) {
    refresh_all(peer);
  } else {
    refresh(peer, counting(peer), role, key);
  }
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
  const auto by = links_.find(link);
  if (heartbeat.process == self_ || by == links_.end()) return;
  const auto found = participants_.find({link, heartbeat.participant});
  if (found == participants_.end() || !found->second.process) return unknown_came(by->second, now);
  Participant& participant = found->second;
  if (participant.process != heartbeat.process) return;
  if (is_late(participant, timing_, now)) participant.regular_since = now;
  participant.heard_at = age < timing_.late ? now - age : now;
  if (!from.is_any()) participant.address = from;
  if (std::exchange(participant.is_silent, false)) join(*found);
  Peer& peer = peers_.at(heartbeat.process);
  if (!speaks_for_all(peer, found->first, timing_, now)) return;
  peer.digests = heartbeat.digests;
  compare(peer, now);
}

/// Either this process or the other one may have lost the other. While participants are being found, Cyclone
/// will probably find this one, too. So this function waits, but no longer than a lease, because new
/// participants may keep coming.
void Peers::unknown_came(Link& link, Time now) const {
  if (!link.unknown_at || now >= *link.unknown_at + 2 * timing_.lease) link.unknown_at = now;
  if (now < std::min(link.stirred_at + 2 * timing_.settle, *link.unknown_at + timing_.lease)) return;
  link.unknown_at.reset();
  link.has_unknown = true;
}

/// Compares the tables of all participants with the digests that have come.
void Peers::compare(Peer& peer, Time now) {
  bool has_changed = false;
  for (auto* const one : peer.participants) {
    bool has_come = true;
    for (const Role role : both_roles) {
      RemoteTable& table = one->second.tables[role];
      if (listened_[role]) has_come &= table.expect((*peer.digests)[role], timing_.heartbeat_pause / 2, now);
    }
    if (has_come) has_changed |= note_as_complete(one->second);
  }
  if (has_changed) refresh_all(peer);
}

bool Peers::is_complete(const Peer& peer, const Participant& participant) const {
  return peer.digests && std::ranges::all_of(both_roles, [&](Role role) {
           return !listened_[role] || participant.tables[role].records().digest() == (*peer.digests)[role];
         });
}

void Peers::refresh(Peer& peer, const std::vector<const Participant*>& counting, Role role,
                    const RecordKey& key) {
  const Record* const holds = newest(counting, role, key);
  const Record* const before = peer.records[role].find(key);
  if (holds != nullptr && before != nullptr && *holds == *before) return;
  const bool was_there = before != nullptr && !before->is_withdrawn();
  const Record now = holds == nullptr ? Record{} : *holds;
  peer.records[role].erase(key);
  if (holds != nullptr) peer.records[role].put(key, now);
  if (was_there || !now.is_withdrawn()) actions_.emplace_back(RecordChanged{peer.process, role, key, now});
}

void Peers::refresh_all(Peer& peer) {
  const std::vector<const Participant*> among = counting(peer);
  for (const Role role : both_roles) {
    std::set<RecordKey> keys;
    for (const auto& [key, record] : peer.records[role].all()) keys.insert(key);
    for (const Participant* const one : among) {
      for (const auto& [key, record] : one->tables[role].records().all()) keys.insert(key);
    }
    for (const RecordKey& key : keys) refresh(peer, among, role, key);
  }
}

/// Returns when the participant becomes suspect. A record counts as missing only if heartbeats go on by the
/// same link, because nothing arrives by a cut link. So a third heartbeat has to follow the two that
/// disagree. The second heartbeat alone may have come while the link worked for a moment that was too short
/// for records to be sent again. Newcomers on the link postpone the time, but by no more than a lease.
/// Otherwise a process that crashes again and again, and is a newcomer each time, would postpone it for ever.
Time Peers::missed_at(LinkId id, const Participant& participant) const {
  if (participant.is_suspect || participant.is_cropped) return Time::max();
  const Link& link = links_.at(id);
  const auto participants = static_cast<int>(std::min(link.participants, participants_counted_max));
  Time::duration timeout = timing_.settle + timing_.settle_each * participants;
  timeout += timeout * static_cast<int>(self_ % 64) / 128;
  if (!participant.has_agreed) timeout *= 2;
  Time missed = Time::max();
  for (const Role role : both_roles) {
    const std::optional<Time> behind = participant.tables[role].behind_since();
    if (!behind || !listened_[role]) continue;
    const Time since = std::max({*behind, *listened_[role], participant.regular_since});
    if (!participant.heard_at || *participant.heard_at <= since) continue;
    missed = std::min(missed, std::max(since, std::min(link.stirred_at, since + timing_.lease)) + timeout);
  }
  return missed;
}

/// Returns when heartbeats that do not arrive by UDP have to be sent through Cyclone. This is early enough
/// for two of them to come before the lease ends.
Time Peers::unheard_at(LinkId id, const Participant& participant) const {
  const Link& link = links_.at(id);
  return participant.heard_at || link.is_unheard || link.retired_at
             ? Time::max()
             : participant.found_at + (timing_.lease - timing_.late);
}

Time Peers::renewal_due(const Link& link) const {
  return link.renewed_at + (*link.misses ? timing_.lease : link.pause);
}

void Peers::look(Time now) {
  looked_at_ = now;
  for (auto& [id, link] : links_) link.misses.reset();
  for (auto& [id, participant] : participants_) {
    if (is_heard(participant)) look_at(id, participant, now);
  }
  look_at_room(now);
  for (auto& [process, peer] : peers_) {
    const PathsCut cut = cut_paths(peer, timing_, now);
    if (std::exchange(peer.cut, cut) != cut) actions_.emplace_back(cut);
  }
  for (auto& [id, link] : links_) look_at_link(id, link, now);
}

void Peers::look_at(const RemoteParticipant& id, Participant& participant, Time now) {
  if (now >= silent_at(participant, timing_)) {
    leave(id, *participant.process);
    participant.is_silent = true;
    for (const Role role : both_roles) participant.tables[role].expect_nothing();
    return;
  }
  Link& link = links_.at(id.link);
  if (now >= missed_at(id.link, participant)) {
    participant.is_suspect = true;
    refresh_all(peers_.at(*participant.process));
  }
  if (participant.is_suspect) {
    link.misses = link.misses.value_or(false) || participant.has_agreed;
    link.misses_from = participant.address;
  }
  if (!participant.heard_at && now >= known_to_it_at(participant, timing_)) link.was_asked = true;
  if (now >= unheard_at(id.link, participant)) {
    link.is_unheard = true;
    actions_.emplace_back(LinkAction{id.link, LinkAction::Kind::use_topic});
  }
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
    if (is_crowded && participant.is_silent) forget_tables(participant);
    const Held held = held_by(participant);
    const bool has_few = held.records < limits_.records && held.bytes <= limits_.bytes / 4 * 3;
    if (!is_crowded && has_few) participant.is_cropped = false;
  }
}

/// A link is renewed at most once in a lease. The pause doubles while renewals do not help, and also while
/// they fail. Requests of other participants to announce ours are answered no more often than heartbeats are
/// sent. A participant that sends heartbeats, but was not found, is asked to announce itself with growing
/// pauses.
void Peers::look_at_link(LinkId id, Link& link, Time now) {
  if (link.retired_at) {
    if (now >= *link.retired_at + timing_.lease) actions_.emplace_back(LinkAction{id, LinkAction::Kind::end});
    return;
  }
  if (link.misses && now >= renewal_due(link)) {
    actions_.emplace_back(LinkAction{id, LinkAction::Kind::renew, link.misses_from});
    link.pause = *link.misses ? timing_.lease : std::min(2 * link.pause, timing_.renew_pause_max);
    link.renewed_at = now;
  } else if (!link.misses && now >= link.renewed_at + 2 * link.pause) {
    link.pause = timing_.lease;
  }
  if (now < announcement_due(link)) return;
  actions_.emplace_back(
      LinkAction{id, link.has_unknown ? LinkAction::Kind::ask : LinkAction::Kind::announce});
  const bool repeats = link.announce_at < link.repeat_until;
  const auto longer = link.has_unknown || repeats ? 2 * link.announce_pause : timing_.heartbeat_every;
  link.announce_pause = std::clamp(longer, timing_.heartbeat_every, timing_.lease);
  link.announce_at = now + link.announce_pause;
  link.has_unknown = link.was_asked = false;
}

Time Peers::announcement_due(const Link& link) {
  const bool is_due = link.has_unknown || link.was_asked || link.announce_at < link.repeat_until;
  return is_due ? link.announce_at : Time::max();
}

Time Peers::next() const {
  Time next = Time::max();
  for (const auto& [id, link] : links_) {
    if (link.retired_at) next = std::min(next, *link.retired_at + timing_.lease);
    if (link.retired_at) continue;
    next = std::min(next, announcement_due(link));
    if (link.misses) next = std::min(next, renewal_due(link));
  }
  for (const auto& [id, participant] : participants_) {
    if (!is_heard(participant)) continue;
    next = std::min({next, silent_at(participant, timing_), missed_at(id.link, participant),
                     unheard_at(id.link, participant)});
    const bool may_be_cut = participant.heard_at && peers_.at(*participant.process).participants.size() > 1;
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
