#include "core/discovery/known_peers.h"

#include <utility>
#include <variant>

namespace sft::core {

KnownPeers::KnownPeers(ProcessId self, const Timing& timing)
    : peers_(self, timing),
      directory_([this](LinkId link, const IpAddress& address) SFT_NO_THREAD_SAFETY_ANALYSIS {
        const auto spec = specs_.find(link);
        return spec != specs_.end() && leads_to(spec->second, address);
      }),
      timing_(timing) {}

/// Actions that concern links are kept until an agent calls look().
void KnownPeers::take_actions() {
  for (PeerAction& action : peers_.take_actions()) {
    if (const auto* const changed = std::get_if<RecordChanged>(&action)) {
      directory_.record_changed(*changed);
    } else if (const auto* const lost = std::get_if<PeerLost>(&action)) {
      directory_.peer_lost(lost->process);
    } else if (const auto* const cut = std::get_if<PathsCut>(&action)) {
      directory_.paths_cut(*cut);
    } else {
      of_links_.push_back(std::move(action));
    }
  }
}

/// The lock is released while nodes are notified, and is held again when the function returns. If another
/// thread is notifying nodes, that thread passes these notices on, too.
void KnownPeers::pass_on_notices(Lock& lock) {
  take_actions();
  if (std::exchange(notifies_, true)) return;
  for (auto batch = directory_.take_notices(); !batch.empty(); batch = directory_.take_notices()) {
    lock.unlock();
    for (const Directory::Notice& notice : batch) {
      for (const std::shared_ptr<ListeningNode>& node : notice.to) node->notify(notice.call);
    }
    lock.lock();
  }
  notifies_ = false;
}

void KnownPeers::pass_on() {
  Lock lock(mutex_);
  pass_on_notices(lock);
}

KnownPeers::Todo KnownPeers::look(const std::vector<HeartbeatTaken>& heartbeats, Time now) {
  const Lock lock(mutex_);
  for (const auto& [link, heartbeat, age, from] : heartbeats)
    peers_.heartbeat_came(link, heartbeat, now, age, from);
  peers_.look(now);
  take_actions();
  return {std::exchange(of_links_, {}), peers_.next()};
}

void KnownPeers::link_made(LinkId link, const LinkSpec& spec) {
  const Lock lock(mutex_);
  peers_.link_made(link, std::chrono::steady_clock::now());
  specs_[link] = spec;
}

void KnownPeers::link_replaced(LinkId link, LinkId by) {
  const Lock lock(mutex_);
  peers_.link_replaced(link, by, std::chrono::steady_clock::now());
}

void KnownPeers::link_retired(LinkId link) {
  const Lock lock(mutex_);
  peers_.link_retired(link, std::chrono::steady_clock::now());
}

void KnownPeers::link_closed(LinkId link) {
  const Lock lock(mutex_);
  peers_.link_gone(link);
  specs_.erase(link);
  const auto is_there = [link](const RemoteParticipant& one) { return one.link == link; };
  std::erase_if(other_releases_, is_there);
  if (std::erase_if(vanilla_, is_there) > 0) note_vanilla_gone();
}

Discovery::Vanilla KnownPeers::vanilla() {
  const Lock lock(mutex_);
  return {!vanilla_.empty(), vanilla_came_};
}

/// Notifies nodes only when the last such participant has gone, since other departures change nothing.
void KnownPeers::note_vanilla_gone() {
  if (vanilla_.empty()) directory_.vanilla_changed();
}

void KnownPeers::tell_of_other_releases(Time now) {
  const Lock lock(mutex_);
  if (other_release_.empty() || now < releases_not_before_) return;
  releases_not_before_ = now + timing_.name_releases_every;
  std::string text = std::exchange(other_release_, "");
  if (const std::uint64_t further = std::exchange(further_releases_, 0); further > 0)
    text += " (" + std::to_string(further) + " more with another protocol have come)";
  directory_.tell(&DiscoveryListener::warned, std::move(text));
}

void KnownPeers::participant_came(const RemoteParticipant& id, const ParticipantData& data, bool is_new) {
  Lock lock(mutex_);
  peers_.participant_found(id, data.process, std::chrono::steady_clock::now());
  if (data.asks && !is_new) peers_.participant_asks(id);
  if (data.uses_topic) of_links_.emplace_back(HeartbeatsMissing{id.link});
  pass_on_notices(lock);
}

void KnownPeers::participant_gone(const RemoteParticipant& id) {
  Lock lock(mutex_);
  peers_.participant_gone(id);
  other_releases_.erase(id);
  if (vanilla_.erase(id) > 0) note_vanilla_gone();
  pass_on_notices(lock);
}

void KnownPeers::vanilla_came(const RemoteParticipant& id) {
  Lock lock(mutex_);
  if (vanilla_.size() >= vanilla_known_max || !vanilla_.insert(id).second) return;
  ++vanilla_came_;
  directory_.vanilla_changed();
  pass_on_notices(lock);
}

/// Notes a participant of another release, unless it was noted before.
void KnownPeers::other_release_seen(const RemoteParticipant& id, std::uint32_t version) {
  const Lock lock(mutex_);
  if (other_releases_.size() >= other_releases_max || !other_releases_.insert(id).second) return;
  if (!other_release_.empty()) {
    ++further_releases_;
    return;
  }
  const auto spec = specs_.find(id.link);
  other_release_ = "a participant with control protocol " + std::to_string(version) + " is on " +
                   (spec == specs_.end() ? "the network" : spec->second.interface) + "; this node has " +
                   std::to_string(control_protocol_version()) +
                   "; they do not see each other: use the same release";
}

void KnownPeers::record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record) {
  Lock lock(mutex_);
  if (!peers_.record_came(by, role, key, std::move(record), std::chrono::steady_clock::now()))
    directory_.refuse("a record of a participant that has as many as one may have");
  pass_on_notices(lock);
}

void KnownPeers::heartbeat_came(LinkId link, const Heartbeat& heartbeat) {
  Lock lock(mutex_);
  peers_.heartbeat_came(link, heartbeat, std::chrono::steady_clock::now());
  pass_on_notices(lock);
}

void KnownPeers::report_came(const RemoteParticipant& by, NodeReport report) {
  Lock lock(mutex_);
  if (const std::optional<ProcessId> process = peers_.process_of(by))
    directory_.report_came(*process, std::move(report));
  pass_on_notices(lock);
}

void KnownPeers::sample_refused(std::string why) {
  Lock lock(mutex_);
  directory_.refuse(std::move(why));
  pass_on_notices(lock);
}

}  // namespace sft::core
