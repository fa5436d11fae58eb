// What is known of other processes, and which nodes of this process are notified of it. Several of Cyclone's
// threads bring news at once. A mutex guards everything. It is not held while nodes are notified, and nothing
// of Cyclone is called under it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/control_link.h"
#include "core/discovery/desired_links.h"
#include "core/discovery/directory.h"
#include "core/discovery/participant_data.h"
#include "core/discovery/peers.h"
#include "core/sync/mutex.h"

namespace sft::core {

class KnownPeers final : public ControlLinkListener {
 public:
  KnownPeers(ProcessId self, const Timing& timing);

  /// Calls act(peers, directory). The resulting notices to nodes wait for pass_on(), which the caller calls
  /// without holding a lock. Nodes are notified in the order of the events, by one thread at a time.
  template <class Act>
  auto with(Act act) {
    const Lock lock(mutex_);
    return act(peers_, directory_);
  }
  void pass_on();

  struct Todo {
    std::vector<PeerAction> of_links{};  ///< RenewLink, EndLink, Announce, HeartbeatsMissing
    Time next = Time::max();             ///< the time of the next look at the latest
  };
  struct HeartbeatTaken {
    LinkId link = 0;
    Heartbeat heartbeat{};
    Time::duration age{};  ///< see Peers::heartbeat_came()
    IpAddress from{};      ///< the address of the sender
  };
  /// Takes the heartbeats that were read, and returns what is due. Needs no lock of the caller.
  Todo look(const std::vector<HeartbeatTaken>& heartbeats, Time now);
  /// Must be called before the link is opened.
  void link_made(LinkId link, const LinkSpec& spec);
  void link_replaced(LinkId link, LinkId by);
  /// The address of the link is gone.
  void link_retired(LinkId link);
  void link_closed(LinkId link);
  /// Tells nodes that participants of other releases have come, if there are new ones. However many of them
  /// an attacker makes up, it does so only now and then.
  void tell_of_other_releases(Time now);

  /// See Discovery::vanilla().
  Discovery::Vanilla vanilla();

  // ControlLinkListener: Cyclone's threads.
  void participant_came(const RemoteParticipant& id, const ParticipantData& data, bool is_new) override;
  void participant_gone(const RemoteParticipant& id) override;
  void other_release_seen(const RemoteParticipant& id, std::uint32_t version) override;
  void vanilla_came(const RemoteParticipant& id) override;
  void record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record) override;
  void heartbeat_came(LinkId link, const Heartbeat& heartbeat) override;
  void report_came(const RemoteParticipant& by, NodeReport report) override;
  void sample_refused(std::string why) override;

 private:
  void take_actions() SFT_REQUIRES(mutex_);
  // Clang does not follow a lock through a reference.
  void pass_on_notices(Lock& lock) SFT_REQUIRES(mutex_) SFT_NO_THREAD_SAFETY_ANALYSIS;
  void note_vanilla_gone() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  Peers peers_ SFT_GUARDED_BY(mutex_);
  Directory directory_ SFT_GUARDED_BY(mutex_);
  const Timing timing_;
  static constexpr std::size_t other_releases_max = 256;  ///< further ones are not looked at
  std::set<RemoteParticipant> other_releases_ SFT_GUARDED_BY(mutex_);
  std::string other_release_ SFT_GUARDED_BY(mutex_);           ///< the first one that nodes were not told of
  std::uint64_t further_releases_ SFT_GUARDED_BY(mutex_) = 0;  ///< participants after it
  Time releases_not_before_ SFT_GUARDED_BY(mutex_){};
  static constexpr std::size_t vanilla_known_max = 1024;  ///< further ones are not looked at
  std::set<RemoteParticipant> vanilla_ SFT_GUARDED_BY(mutex_);
  std::uint64_t vanilla_came_ SFT_GUARDED_BY(mutex_) = 0;
  std::map<LinkId, LinkSpec> specs_ SFT_GUARDED_BY(mutex_);
  std::vector<PeerAction> of_links_ SFT_GUARDED_BY(mutex_);
  bool notifies_ SFT_GUARDED_BY(mutex_) = false;  ///< some thread is in pass_on_notices()
};

}  // namespace sft::core
