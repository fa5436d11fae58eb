#include "core/discovery/peer.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace sft::core {

namespace {

/// Returns the record of that key with the greatest revision; null if there is none.
const Record* newest(const std::vector<const Participant*>& among, Role role, const RecordKey& key) {
  const Record* newest = nullptr;
  for (const Participant* const one : among) {
    const Record* const record = one->tables[role].records().find(key);
    if (record != nullptr && (newest == nullptr || record->revision > newest->revision)) newest = record;
  }
  return newest;
}

}  // namespace

void Peer::join(const RemoteParticipant& id, Participant& participant) {
  members_.push_back({id, &participant});
  links_.insert(id.link);
  if (is_complete(participant)) note_as_complete(participant);
  refresh_all();
}

/// Removes the participant. Then moves participants that have agreed to the front, so that no participant
/// that has never agreed becomes the first.
void Peer::leave(const RemoteParticipant& id) {
  std::erase_if(members_, [&](const Member& one) { return one.id == id; });
  std::ranges::stable_partition(members_, [](const Member& one) { return one.participant->has_agreed; });
  refresh_all();
}

void Peer::heartbeat_came(const RemoteParticipant& by, const PerRole<std::uint64_t>& digests, Time now) {
  if (!speaks_for_all(by, now)) return;
  digests_ = digests;
  bool has_changed = false;
  for (const Member& one : members_) {
    bool has_come = true;
    for (const Role role : both_roles) {
      if (listened_[role])
        has_come &= one.participant->tables[role].expect(digests[role], timing_.heartbeat_pause / 2, now);
    }
    if (has_come) has_changed |= note_as_complete(*one.participant);
  }
  if (has_changed) refresh_all();
}

void Peer::record_came(Participant& of, Role role, const RecordKey& key) {
  if (is_complete(of) && note_as_complete(of)) {
    refresh_all();
  } else {
    refresh(counting(), role, key);
  }
}

void Peer::suspect(Participant& participant) {
  participant.is_suspect = true;
  refresh_all();
}

void Peer::link_replaced(LinkId link, LinkId by) {
  if (links_.contains(link)) links_.insert(by);
}

/// The process may have several participants on a link, since it makes its own links anew. A participant
/// without heartbeats decides nothing until it counts as silent, because a firewall may let only Cyclone's
/// datagrams pass.
Peer::Paths Peer::paths(Time now) const {
  if (links_.size() < 2) return {};
  std::set<LinkId> in_time, unknown;
  for (const Member& one : members_) {
    if (!one.participant->heard_at)
      unknown.insert(one.id.link);
    else if (!one.participant->is_late(timing_, now))
      in_time.insert(one.id.link);
  }
  Paths paths{.heard = {in_time.begin(), in_time.end()}};
  std::ranges::copy_if(links_, std::back_inserter(paths.cut),
                       [&](LinkId link) { return !in_time.contains(link) && !unknown.contains(link); });
  return paths.cut.empty() || paths.heard.empty() ? Paths{} : paths;
}

bool Peer::is_complete(const Participant& participant) const {
  return digests_ && std::ranges::all_of(both_roles, [&](Role role) {
           return !listened_[role] || participant.tables[role].records().digest() == (*digests_)[role];
         });
}

/// Notes that the tables match the digests. Empty tables prove nothing, so they do not count as agreement.
/// Returns true if the set of participants that count has changed.
bool Peer::note_as_complete(Participant& participant) {
  const bool was_suspect = std::exchange(participant.is_suspect, false);
  const bool has_any = std::ranges::any_of(
      both_roles, [&](Role role) { return !participant.tables[role].records().all().empty(); });
  const bool is_new = has_any && !std::exchange(participant.has_agreed, true);
  return was_suspect || is_new;
}

/// Returns true if the heartbeats of this participant count. Only those of one participant do. It is the
/// first participant that is not late and either has agreed or is the first of all. If there is none, it is
/// the first participant that is not late.
bool Peer::speaks_for_all(const RemoteParticipant& id, Time now) const {
  const auto is_in_time = [&](const Member& one) { return !one.participant->is_late(timing_, now); };
  const auto may_speak = [&](const Member& one) {
    return is_in_time(one) && (one.participant->has_agreed || &one == &members_.front());
  };
  auto speaker = std::ranges::find_if(members_, may_speak);
  if (speaker == members_.end()) speaker = std::ranges::find_if(members_, is_in_time);
  return speaker != members_.end() && speaker->id == id;
}

std::vector<const Participant*> Peer::counting() const {
  std::vector<const Participant*> agreed, trusted;
  for (const Member& one : members_) {
    if (!one.participant->has_agreed) continue;
    agreed.push_back(one.participant);
    if (!one.participant->is_suspect) trusted.push_back(one.participant);
  }
  if (!trusted.empty()) return trusted;
  if (agreed.empty() && !members_.empty()) agreed.push_back(members_.front().participant);
  return agreed;
}

void Peer::refresh(const std::vector<const Participant*>& counting, Role role, const RecordKey& key) {
  const Record* const holds = newest(counting, role, key);
  const Record* const before = records_[role].find(key);
  if (holds != nullptr && before != nullptr && *holds == *before) return;
  const bool was_there = before != nullptr && !before->is_withdrawn();
  const Record now = holds == nullptr ? Record{} : *holds;
  records_[role].erase(key);
  if (holds != nullptr) records_[role].put(key, now);
  if (was_there || !now.is_withdrawn()) changed_(role, key, now);
}

void Peer::refresh_all() {
  const std::vector<const Participant*> among = counting();
  for (const Role role : both_roles) {
    std::set<RecordKey> keys;
    for (const auto& [key, record] : records_[role].all()) keys.insert(key);
    for (const Participant* const one : among) {
      for (const auto& [key, record] : one->tables[role].records().all()) keys.insert(key);
    }
    for (const RecordKey& key : keys) refresh(among, role, key);
  }
}

}  // namespace sft::core
