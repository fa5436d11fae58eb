#include "core/discovery/known_peers.h"

#include <utility>
#include <variant>

namespace sft::core {

KnownPeers::KnownPeers(ProcessId self, const Timing& timing)
    : peers_(self, timing),
      directory_([this](LinkId link, const IpAddress& address) SFT_NO_THREAD_SAFETY_ANALYSIS {
        const auto spec = specs_.find(link);
        return spec != specs_.end() && leads_to(spec->second, address);
      }) {}

KnownPeers::Turn::Turn(KnownPeers& known) : known_(known) { known_.mutex_.lock(); }

KnownPeers::Turn::~Turn() {
  known_.take_actions();
  const auto woken = known_.directory_.take_woken();
  known_.mutex_.unlock();
  for (const auto& node : woken) node->wake();
}

/// Notifies nodes of what has changed. Actions that concern links are kept until an agent calls look().
void KnownPeers::take_actions() {
  for (const PeerAction& action : peers_.take_actions()) {
    if (const auto* const changed = std::get_if<RecordChanged>(&action)) {
      directory_.record_changed(*changed);
    } else if (const auto* const lost = std::get_if<PeerLost>(&action)) {
      directory_.peer_lost(lost->process);
    } else if (const auto* const cut = std::get_if<PathsCut>(&action)) {
      directory_.paths_cut(*cut);
    } else {
      of_links_.push_back(std::get<LinkAction>(action));
    }
  }
}

KnownPeers::Todo KnownPeers::look(Time now) {
  const Turn turn(*this);
  peers_.look(now);
  take_actions();
  for (const std::string& text : std::exchange(warnings_, {}))
    directory_.log_news(Directory::News::warning, text);
  return {std::exchange(of_links_, {}), peers_.next()};
}

void KnownPeers::link_made(LinkId link, const LinkSpec& spec, bool heartbeats_find) {
  const Turn turn(*this);
  peers_.link_made(link, std::chrono::steady_clock::now(), heartbeats_find);
  specs_[link] = spec;
}

void KnownPeers::link_closed(LinkId link) {
  const Turn turn(*this);
  peers_.link_gone(link);
  specs_.erase(link);
  if (std::erase_if(vanilla_, [link](const RemoteParticipant& one) { return one.link == link; }) > 0)
    note_vanilla_gone();
}

Discovery::Vanilla KnownPeers::vanilla() {
  const Turn turn(*this);
  return {!vanilla_.empty(), vanilla_came_};
}

/// Notifies nodes only when the last such participant has gone, since other departures change nothing.
void KnownPeers::note_vanilla_gone() {
  if (vanilla_.empty()) directory_.vanilla_changed();
}

void KnownPeers::participant_came(const RemoteParticipant& id, const ParticipantData& data) {
  const Turn turn(*this);
  peers_.participant_found(id, data.process, std::chrono::steady_clock::now(), data.asks);
  if (data.uses_topic) of_links_.push_back({id.link, LinkAction::Kind::use_topic});
}

void KnownPeers::participant_gone(const RemoteParticipant& id) {
  const Turn turn(*this);
  peers_.participant_gone(id);
  if (vanilla_.erase(id) > 0) note_vanilla_gone();
}

void KnownPeers::vanilla_came(const RemoteParticipant& id) {
  const Turn turn(*this);
  if (vanilla_.size() >= vanilla_known_max || !vanilla_.insert(id).second) return;
  ++vanilla_came_;
  directory_.vanilla_changed();
}

void KnownPeers::other_release_seen(LinkId link, std::uint32_t version) {
  const Turn turn(*this);
  if (releases_.size() >= releases_max || !releases_.insert(version).second) return;
  const auto spec = specs_.find(link);
  warnings_.push_back("a participant with control protocol " + std::to_string(version) + " is on " +
                      (spec == specs_.end() ? "the network" : spec->second.interface) + "; this node has " +
                      std::to_string(control_protocol_version()) +
                      "; they do not see each other: use the same release");
}

void KnownPeers::record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record) {
  const Turn turn(*this);
  if (!peers_.record_came(by, role, key, std::move(record), std::chrono::steady_clock::now()))
    directory_.log_news(Directory::News::too_much,
                        "a record of a participant that has as many as one may have");
}

void KnownPeers::heartbeat_came(LinkId link, const Heartbeat& heartbeat, Time now, Time::duration age,
                                const IpAddress& from) {
  const Turn turn(*this);
  peers_.heartbeat_came(link, heartbeat, now, age, from);
}

void KnownPeers::report_came(const RemoteParticipant& by, NodeReport report) {
  const Turn turn(*this);
  if (const std::optional<ProcessId> process = peers_.process_of(by))
    directory_.report_came(*process, std::move(report));
}

void KnownPeers::sample_refused(const std::string& why) {
  const Turn turn(*this);
  directory_.log_news(Directory::News::malformed, why);
}

}  // namespace sft::core
