#include "tests/simulation/control/control_world.h"

#include <algorithm>
#include <sstream>
#include <variant>

namespace sft::core::test {

namespace {

constexpr Time::duration step = 10ms;
/// The longest pause between two turns of the agent that does the periodic work of discovery.
constexpr Time::duration look_every = 932ms;
constexpr Time::duration resent_within = 300ms;

RemoteParticipant participant_of(const SimLink& writer, const SimLink& hearer) {
  return {hearer.id, writer.guid};
}

std::map<RecordKey, Record> in_force(const Records& records) {
  std::map<RecordKey, Record> present;
  for (const auto& [key, record] : records.all()) {
    if (!record.is_withdrawn()) present.emplace(key, record);
  }
  return present;
}

}  // namespace

SimProcess& ControlWorld::start(int networks) {
  SimProcess& process = *processes_.emplace_back(std::make_unique<SimProcess>(random_() | 1, timing_));
  for (const Role role : both_roles) process.peers.listen(role, now_);
  for (int network = 0; network < networks; ++network) open(process, network, std::nullopt);
  return process;
}

void ControlWorld::open(SimProcess& process, int network, std::optional<LinkId> instead_of) {
  SimLink& link = *links_.emplace_back(std::make_unique<SimLink>());
  link = {.process = &process, .network = network, .id = static_cast<LinkId>(links_.size())};
  for (std::uint8_t& octet : link.guid) octet = static_cast<std::uint8_t>(random_());
  process.links.push_back(&link);
  process.peers.link_made(link.id, now_);
  if (instead_of) process.peers.link_replaced(*instead_of, link.id, now_);
  announce(link, false);
}

void ControlWorld::close(SimLink& link, bool says_so) {
  link.is_open = false;
  std::erase(link.process->links, &link);
  if (!link.process->is_killed) link.process->peers.link_gone(link.id);
  if (!says_so) return;
  each_hearer(link, [&](SimLink& hearer) {
    if (!is_cut(link.network)) forget(hearer, link);
  });
}

void ControlWorld::kill(SimProcess& process) {
  process.is_killed = true;
  const bool is_orderly = chance(0.3);
  for (SimLink* const link : std::vector(process.links)) close(*link, is_orderly);
}

void ControlWorld::cut(int network, bool is_cut) {
  if (is_cut) {
    cuts_[network] = true;
    return;
  }
  cuts_.erase(network);
  for (const auto& hearer : links_) {  // Records that were written during the cut are sent again.
    if (hearer->network != network || !hearer->is_open) continue;
    each_hearer(*hearer, [&](SimLink& writer) {
      at(now_ + up_to(resent_within),
         [this, &to = *hearer, &writer, number = channel(*hearer, writer).number] {
           deliver(to, writer, number);
         });
    });
  }
}

void ControlWorld::announce(SimLink& link, bool asks) {
  each_hearer(link, [&](SimLink& hearer) {
    if (chance(loss_)) return;
    at(now_ + up_to(5ms), [this, &hearer, &link, asks] { hear_announcement(hearer, link, asks, false); });
  });
}

/// Handles an announcement of the participant `of`. If the participant was unknown, the hearer finds it, and
/// Cyclone answers the announcement.
void ControlWorld::hear_announcement(SimLink& hearer, SimLink& of, bool asks, bool is_answer) {
  if (!reaches(of, hearer)) return;
  Channel& known = channel(hearer, of);
  known.heard_at = now_;
  if (known.is_found) {
    if (asks) hearer.process->peers.participant_found(participant_of(of, hearer), of.process->id, now_, asks);
    return;
  }
  find(hearer, of);
  if (is_answer || chance(loss_)) return;
  at(now_ + up_to(5ms), [this, &hearer, &of] { hear_announcement(of, hearer, false, true); });
}

/// Makes the participant `hearer` find the participant `writer`. Records of `writer` may arrive before
/// Cyclone reports this.
void ControlWorld::find(SimLink& hearer, SimLink& writer) {
  Channel& found = channel(hearer, writer);
  found.is_found = true;
  found.is_stalled = false;
  const unsigned number = ++found.number;
  const auto tell = [this, &hearer, &writer, number] {
    if (hearer.is_open && channel(hearer, writer).number == number)
      hearer.process->peers.participant_found(participant_of(writer, hearer), writer.process->id, now_);
  };
  if (chance(0.3)) {
    at(now_ + 3ms, tell);
  } else {
    tell();
  }
  for (const Role role : both_roles) {
    for (const auto& [key, record] : writer.process->own.records(role).all())
      write(hearer, writer, role, key, record);
  }
}

void ControlWorld::forget(SimLink& hearer, SimLink& writer) {
  Channel& known = channel(hearer, writer);
  if (!known.is_found) return;
  const unsigned number = known.number + 1;
  known = Channel{};
  known.number = number;
  if (hearer.is_open) hearer.process->peers.participant_gone(participant_of(writer, hearer));
}

void ControlWorld::write_to_all(SimProcess& process, Role role, const OwnRecords::Change& change) {
  for (SimLink* const writer : process.links) {
    each_hearer(*writer, [&](SimLink& hearer) { write(hearer, *writer, role, change.key, change.record); });
  }
}

/// Sends a record. Records arrive in the order of writing, unless the channel to `hearer` is stalled. Lost
/// records are sent again.
void ControlWorld::write(SimLink& hearer, SimLink& writer, Role role, const RecordKey& key,
                         const Record& record) {
  Channel& to = channel(hearer, writer);
  if (!to.is_found || to.is_stalled) return;
  const Time soon = now_ + up_to(chance(loss_) ? resent_within : 2ms);
  const Time due = to.written.empty() ? soon : std::max(soon, to.written.back().first);
  to.written.emplace_back(due, [this, &hearer, &writer, role, key, record] {
    hearer.process->peers.record_came(participant_of(writer, hearer), role, key, record, now_);
  });
  at(due, [this, &hearer, &writer, number = to.number] { deliver(hearer, writer, number); });
}

void ControlWorld::deliver(SimLink& hearer, SimLink& writer, unsigned number) {
  Channel& by = channel(hearer, writer);
  if (by.number != number || !reaches(writer, hearer)) return;
  by.heard_at = now_;
  while (!by.written.empty() && by.written.front().first <= now_) {
    const auto arrive = std::move(by.written.front().second);
    by.written.pop_front();
    if (!by.is_stalled) arrive();
  }
}

void ControlWorld::give_heartbeat(SimLink& link) {
  const Heartbeat heartbeat{link.guid, link.process->id, link.process->own.digests()};
  each_hearer(link, [&](SimLink& hearer) {
    if (chance(loss_)) return;
    at(now_ + up_to(5ms), [this, &hearer, &link, heartbeat] {
      if (!reaches(link, hearer)) return;
      channel(hearer, link).heard_at = now_;
      hearer.unread.emplace_back(heartbeat, now_);
    });
  });
}

void ControlWorld::look(SimProcess& process) {
  process.looked_at = now_;
  for (SimLink* const link : process.links) {
    for (const auto& [heartbeat, came_at] : std::exchange(link->unread, {}))
      process.peers.heartbeat_came(link->id, heartbeat, now_, now_ - came_at);
  }
  process.peers.look(now_);
  act(process);
  if (!process.own.is_heartbeat_due(now_)) return;
  process.own.heartbeat_given(now_);
  for (SimLink* const link : process.links) give_heartbeat(*link);
}

void ControlWorld::act(SimProcess& process) {
  for (const PeerAction& action : process.peers.take_actions()) {
    note(process, action);
    const auto* const of_link = std::get_if<LinkAction>(&action);
    if (of_link == nullptr) continue;
    using Kind = LinkAction::Kind;
    renewals_ += of_link->kind == Kind::renew ? 1 : 0;
    SimLink* const link = link_of(process, of_link->link);
    if (link == nullptr) continue;
    if (of_link->kind == Kind::renew) open(process, link->network, link->id);
    if (of_link->kind == Kind::end) close(*link, true);
    if (of_link->kind == Kind::announce || of_link->kind == Kind::ask)
      announce(*link, of_link->kind == Kind::ask);
  }
}

void ControlWorld::note(SimProcess& process, const PeerAction& action) {
  if (const auto* const lost = std::get_if<PeerLost>(&action)) process.mirror.erase(lost->process);
  const auto* const changed = std::get_if<RecordChanged>(&action);
  if (changed == nullptr) return;
  auto& records = process.mirror[changed->process][changed->role];
  const auto before = records.find(changed->key);
  if (before != records.end() && changed->record.revision < before->second.revision) ++steps_back_;
  records.erase(changed->key);
  if (!changed->record.is_withdrawn()) records.emplace(changed->key, changed->record);
}

SimLink* ControlWorld::link_of(SimProcess& process, LinkId id) {
  const auto link = std::ranges::find(process.links, id, &SimLink::id);
  return link == process.links.end() ? nullptr : *link;
}

void ControlWorld::run(Time::duration time) {
  const Time end = now_ + time;
  while (now_ < end) {
    now_ += step;
    while (!events_.empty() && events_.top().at <= now_) {
      const Event event = events_.top();
      events_.pop();
      event.act();
    }
    for (auto& [pair, known] : channels_) {
      if (known.is_found && now_ - known.heard_at > timing_.cyclone_lease)
        forget(*links_[pair.first - 1], *links_[pair.second - 1]);
    }
    for (const auto& process : processes_) {
      if (process->is_killed) continue;
      act(*process);  // actions that Cyclone's threads have caused are done at once
      const Time due =
          std::min({process->looked_at + look_every, process->peers.next(), process->own.heartbeat_due()});
      if (now_ >= due) look(*process);
    }
  }
}

std::vector<std::byte> ControlWorld::random_body() {
  std::vector<std::byte> body(1 + below(40));
  for (std::byte& byte : body) byte = static_cast<std::byte>(random_());
  return body;
}

void ControlWorld::change(SimProcess& process) {
  if (process.open.size() > 3 && chance(0.3)) {
    const auto closed = process.open.begin() + static_cast<std::ptrdiff_t>(below(process.open.size()));
    const auto [role, owner] = *closed;
    process.open.erase(closed);
    for (const OwnRecords::Change& change : process.own.withdraw(role, owner, now_))
      write_to_all(process, role, change);
    return;
  }
  if (process.open.empty() || chance(0.4)) process.open.emplace_back(both_roles[below(2)], ++process.owners);
  const auto [role, owner] = process.open[below(process.open.size())];
  const auto kind = chance(0.5) ? RecordKind::announcement : RecordKind::request;
  if (const auto change = process.own.put(role, owner, kind, random_body(), now_))
    write_to_all(process, role, *change);
}

void ControlWorld::attack() {
  std::vector<std::pair<SimLink*, SimLink*>> known;
  for (const auto& [pair, one] : channels_) {
    SimLink* const hearer = links_[pair.first - 1].get();
    SimLink* const writer = links_[pair.second - 1].get();
    if (one.is_found && hearer->is_open && writer->is_open) known.emplace_back(hearer, writer);
  }
  if (known.empty()) return;
  const auto [hearer, writer] = known[below(known.size())];
  Peers& victim = hearer->process->peers;
  const RemoteParticipant as = participant_of(*writer, *hearer);
  const Role role = both_roles[below(2)];
  const auto& own = writer->process->own.records(role).all();
  const RecordKey key = own.empty() ? RecordKey{} : own.begin()->first;
  const auto lie = std::make_shared<const std::vector<std::byte>>(random_body());
  const std::uint64_t greatest = ~std::uint64_t{0};
  switch (below(7)) {
    case 0:  // a sequence number far ahead, which stalls the channel
      channel(*hearer, *writer).is_stalled = true;
      break;
    case 1:  // a forged disposal of the participant
      forget(*hearer, *writer);
      break;
    case 2:
      victim.record_came(as, role, {900, RecordKind::announcement}, {greatest, lie}, now_);
      break;
    case 3:
      victim.record_came(as, role, key, {greatest, lie}, now_);
      break;
    case 4:
      victim.record_came(as, role, key, {greatest, nullptr}, now_);
      break;
    case 5:  // the next revision, which makes the true record outdated
      victim.record_came(as, role, key, {own.empty() ? 1 : own.begin()->second.revision, lie}, now_);
      break;
    default:
      hearer->unread.emplace_back(Heartbeat{writer->guid, writer->process->id, {random_(), random_()}}, now_);
  }
}

void ControlWorld::claim(const SimProcess& process, Time::duration lasts) {
  ParticipantGuid guid{};
  for (std::uint8_t& octet : guid) octet = static_cast<std::uint8_t>(random_());
  const PerRole<std::uint64_t> digests{random_(), random_()};
  const auto lie = std::make_shared<const std::vector<std::byte>>(random_body());
  for (SimLink* const own : process.links) {
    each_hearer(*own, [&](SimLink& hearer) {
      const RemoteParticipant as{hearer.id, guid};
      Peers& victim = hearer.process->peers;
      victim.participant_found(as, process.id, now_);
      victim.record_came(as, Role::writer, {0, RecordKind::announcement}, {~std::uint64_t{0}, lie}, now_);
      for (Time::duration after{}; after < lasts; after += 1s) {
        at(now_ + after, [this, &hearer, guid, id = process.id, digests] {
          if (hearer.is_open) hearer.unread.emplace_back(Heartbeat{guid, id, digests}, now_);
        });
      }
      at(now_ + lasts, [&hearer, as] {
        if (hearer.is_open) hearer.process->peers.participant_gone(as);
      });
    });
  }
}

std::string ControlWorld::what_is_wrong() const {
  std::ostringstream wrong;
  for (const auto& hearer : processes_) {
    if (hearer->is_killed) continue;
    for (const auto& other : processes_) {
      if (other == hearer) continue;
      const auto records = hearer->mirror.find(other->id);
      const bool is_known =
          other->is_killed ? records != hearer->mirror.end() : hearer->peers.find(other->id) != nullptr;
      if (is_known == other->is_killed) {
        wrong << other->id << (is_known ? " was killed, and " : " lives, and ") << hearer->id
              << (is_known ? " knows it; " : " does not know it; ");
        continue;
      }
      if (!is_known) continue;
      for (const Role role : both_roles) {
        const auto known =
            records == hearer->mirror.end() ? std::map<RecordKey, Record>{} : records->second[role];
        if (known != in_force(other->own.records(role)))
          wrong << hearer->id << " knows " << known.size() << " records of the "
                << in_force(other->own.records(role)).size() << " of " << other->id << "; ";
      }
    }
  }
  return wrong.str();
}

}  // namespace sft::core::test
