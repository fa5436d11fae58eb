// Keeps the state of all other processes, and what the nodes of this process have to be notified of. Several
// of Cyclone's threads report events at the same time. One mutex guards all members. While it is held,
// neither a function of Cyclone nor one of a node is called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/discovery/directory.h"
#include "core/discovery/participant_data.h"
#include "core/discovery/peers.h"
#include "core/sync/mutex.h"

namespace sft::core {

class KnownPeers {
 public:
  KnownPeers(ProcessId self, const Timing& timing);

  /// Calls act(peers, directory).
  template <class Act>
  auto with(Act act) {
    const Turn turn(*this);
    return act(peers_, directory_);
  }

  struct Todo {
    std::vector<LinkAction> of_links{};
    Time next = Time::max();  ///< the time by which look() must be called again
  };
  /// Returns the actions that are due. Must be called after heartbeat_came() for all heartbeats that were
  /// read. The caller needs no lock.
  Todo look(Time now);
  /// Must be called before the link is opened.
  void link_made(LinkId link, const LinkSpec& spec, bool heartbeats_find);
  void link_closed(LinkId link);
  /// See Discovery::vanilla().
  Discovery::Vanilla vanilla();

  // Events that Cyclone's threads and agents report, several at the same time.

  /// Cyclone has found a participant of a process of this release, or its user data have changed.
  void participant_came(const RemoteParticipant& id, const ParticipantData& data);
  void participant_gone(const RemoteParticipant& id);
  /// look() notifies nodes of a release that was not seen before.
  void other_release_seen(LinkId link, std::uint32_t version);
  /// A participant that does not belong to SFT was found on a link without DDS Security. Called again if
  /// its user data have changed.
  void vanilla_came(const RemoteParticipant& id);
  void record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record);
  /// See Peers::heartbeat_came().
  void heartbeat_came(LinkId link, const Heartbeat& heartbeat, Time now, Time::duration age = {},
                      const IpAddress& from = {});
  void report_came(const RemoteParticipant& by, NodeReport report);
  void sample_refused(const std::string& why);

 private:
  /// Holds the mutex. At its end, it applies the actions of Peers, unlocks the mutex, and then wakes the
  /// nodes that have something to take.
  class SFT_SCOPED_CAPABILITY Turn {
   public:
    explicit Turn(KnownPeers& known) SFT_ACQUIRE(known.mutex_) SFT_NO_THREAD_SAFETY_ANALYSIS;
    ~Turn() SFT_RELEASE() SFT_NO_THREAD_SAFETY_ANALYSIS;
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    KnownPeers& known_;
  };
  void take_actions() SFT_REQUIRES(mutex_);
  void note_vanilla_gone() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  Peers peers_ SFT_GUARDED_BY(mutex_);
  Directory directory_ SFT_GUARDED_BY(mutex_);
  static constexpr std::size_t releases_max = 16;  ///< the maximum number of other releases that are named,
                                                   ///< since attackers may make up releases
  std::set<std::uint32_t> releases_ SFT_GUARDED_BY(mutex_);   ///< the other releases that were seen
  std::vector<std::string> warnings_ SFT_GUARDED_BY(mutex_);  ///< texts of which nodes were not notified yet
  static constexpr std::size_t vanilla_known_max = 1024;  ///< the maximum number of remembered participants;
                                                          ///< further ones are ignored
  std::set<RemoteParticipant> vanilla_ SFT_GUARDED_BY(mutex_);
  std::uint64_t vanilla_came_ SFT_GUARDED_BY(mutex_) = 0;
  std::map<LinkId, LinkSpec> specs_ SFT_GUARDED_BY(mutex_);
  std::vector<LinkAction> of_links_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
