// Keeps the state of all other processes, and the nodes of this process that are notified of changes. Several
// of Cyclone's threads report events at the same time. One mutex guards all members. It is released while
// nodes are notified, and no function of Cyclone is called while it is held.
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

  /// Calls act(peers, directory). The resulting notices to nodes are queued until pass_on() is called. The
  /// caller must call it, without holding a lock. Nodes are notified in the order of the events, by one
  /// thread at a time.
  template <class Act>
  auto with(Act act) {
    const Lock lock(mutex_);
    return act(peers_, directory_);
  }
  void pass_on();

  struct Todo {
    std::vector<PeerAction> of_links{};  ///< those of the kinds RenewLink, EndLink, Announce and
                                         ///< HeartbeatsMissing
    Time next = Time::max();             ///< the time by which look() must be called again
  };
  struct HeartbeatTaken {
    LinkId link = 0;
    Heartbeat heartbeat{};
    Time::duration age{};  ///< the time for which the heartbeat has waited; see Peers::heartbeat_came()
    IpAddress from{};      ///< the address of the sender
  };
  /// Processes the heartbeats that were read, and returns the actions that are due. The caller needs no
  /// lock.
  Todo look(const std::vector<HeartbeatTaken>& heartbeats, Time now);
  /// Must be called before the link is opened.
  void link_made(LinkId link, const LinkSpec& spec);
  void link_replaced(LinkId link, LinkId by);
  /// Called when the address of the link is gone.
  void link_retired(LinkId link);
  void link_closed(LinkId link);
  /// Notifies nodes that participants of other releases have come, if there are new ones. It does so at most
  /// once in Timing::name_releases_every, since an attacker may make up any number of participants.
  void tell_of_other_releases(Time now);

  /// See Discovery::vanilla().
  Discovery::Vanilla vanilla();

  // Functions of ControlLinkListener, called by Cyclone's threads.
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
  // Clang's analysis of thread safety does not follow a lock that is passed by reference.
  void pass_on_notices(Lock& lock) SFT_REQUIRES(mutex_) SFT_NO_THREAD_SAFETY_ANALYSIS;
  void note_vanilla_gone() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  Peers peers_ SFT_GUARDED_BY(mutex_);
  Directory directory_ SFT_GUARDED_BY(mutex_);
  const Timing timing_;
  static constexpr std::size_t other_releases_max = 256;  ///< the maximum number of remembered participants
                                                          ///< of other releases; further ones are ignored
  std::set<RemoteParticipant> other_releases_ SFT_GUARDED_BY(mutex_);
  std::string other_release_ SFT_GUARDED_BY(mutex_);           ///< the first of the other releases of which
                                                               ///< nodes were not notified yet
  std::uint64_t further_releases_ SFT_GUARDED_BY(mutex_) = 0;  ///< the number of participants found after the
                                                               ///< one in `other_release_`
  Time releases_not_before_ SFT_GUARDED_BY(mutex_){};
  static constexpr std::size_t vanilla_known_max = 1024;  ///< the maximum number of remembered participants;
                                                          ///< further ones are ignored
  std::set<RemoteParticipant> vanilla_ SFT_GUARDED_BY(mutex_);
  std::uint64_t vanilla_came_ SFT_GUARDED_BY(mutex_) = 0;
  std::map<LinkId, LinkSpec> specs_ SFT_GUARDED_BY(mutex_);
  std::vector<PeerAction> of_links_ SFT_GUARDED_BY(mutex_);
  bool notifies_ SFT_GUARDED_BY(mutex_) = false;  ///< some thread is in pass_on_notices()
};

}  // namespace sft::core
