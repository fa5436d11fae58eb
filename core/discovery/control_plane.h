// The discovery that all nodes of a process with equal options share. It has one participant on each link,
// one table of what other processes have announced, and one heartbeat. So a process costs other processes
// no more than a single node does, apart from what its nodes announce. Any thread may use it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/discovery/dds_config.h"
#include "core/discovery/discovery.h"
#include "core/discovery/known_peers.h"
#include "core/discovery/links.h"
#include "core/discovery/own_records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"
#include "core/platform/network_monitor.h"
#include "core/platform/peer_addresses.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// Decides which links are wanted, writes the records of the process, and describes the configuration to the
/// user.
class ControlPlane {
 public:
  /// Returns the control plane that nodes of this process with equal options share. If there is none yet,
  /// makes a new one.
  static Result<std::shared_ptr<ControlPlane>> of(const DiscoveryOptions& options);

  ControlPlane(DdsConfig config, const ThreadSettings& threads);
  Result<void> open();
  ControlPlane(const ControlPlane&) = delete;
  ControlPlane& operator=(const ControlPlane&) = delete;
  class OfNode;  ///< the Discovery of one node

 private:
  /// Calls question(directory), and returns the answer.
  template <class Question>
  auto ask(Question question) {
    return known_.with([&](Peers&, Directory& directory) { return question(directory); });
  }
  Discovery::Configuration configuration() const;
  void put(Role role, EndpointId owner, RecordKind kind, std::vector<std::byte> body, Time now)
      SFT_REQUIRES(mutex_);
  void withdraw_records(EndpointId id, Time now) SFT_REQUIRES(mutex_);
  void withdraw_owned(Role role, std::uint64_t owner, Time now) SFT_REQUIRES(mutex_);
  void write_inquiries(Time now) SFT_REQUIRES(mutex_);
  Result<void> use_links() SFT_REQUIRES(mutex_);
  void give_heartbeats(Time now) SFT_REQUIRES(mutex_);
  Time look(Time now) SFT_REQUIRES(mutex_);
  void try_again(Time now) SFT_REQUIRES(mutex_);
  void act(const LinkAction& action, Time now) SFT_REQUIRES(mutex_);
  void renew_link(const LinkAction& action, Time now) SFT_REQUIRES(mutex_);
  void look_at_interfaces(Time now) SFT_REQUIRES(mutex_);
  Time look_at_peers_by_name(Time now) SFT_REQUIRES(mutex_);
  Result<void> use_interfaces(const DesiredLinks& desired) SFT_REQUIRES(mutex_);
  void give_up() SFT_REQUIRES(mutex_);
  using News = DiscoveryNews::Kind;
  void log_news(News news, const std::string& text);
  void describe(const DesiredLinks& desired) SFT_REQUIRES(mutex_);

  const DdsConfig config_;
  const Timing timing_;
  const ProcessId process_;
  KnownPeers known_;

  /// Held while records are written, so that all links get the records in the same order, and while links
  /// are opened and closed. Agents and threads that open or close a node lock this mutex. The only lock
  /// that they may already hold then is OpenPlanes::mutex.
  Mutex mutex_;
  bool monitors_ SFT_GUARDED_BY(mutex_) = true;  ///< true: interfaces are watched; false once the program has
                                                 ///< closed the sockets
  NetworkMonitor monitor_ SFT_GUARDED_BY(mutex_);
  Time look_at_interfaces_at_ SFT_GUARDED_BY(mutex_){};
  Time try_again_at_ SFT_GUARDED_BY(mutex_){};
  std::string failure_ SFT_GUARDED_BY(mutex_);  ///< the error of the last try_again(); empty if it succeeded
  std::vector<HostInterface> interfaces_ SFT_GUARDED_BY(mutex_);
  PeerAddresses peers_by_name_ SFT_GUARDED_BY(mutex_);
  std::map<Inquiry, std::uint64_t> inquiries_ SFT_GUARDED_BY(mutex_);  ///< our inquiries, and the owner
                                                                       ///< number of each one's record
  OwnRecords own_ SFT_GUARDED_BY(mutex_);
  LinkUse use_ SFT_GUARDED_BY(mutex_);
  Links links_ SFT_GUARDED_BY(mutex_);  ///< declared after `known_`, so that it is destroyed first, since its
                                        ///< threads use `known_`

  mutable Mutex configuration_mutex_;
  Discovery::Configuration configuration_ SFT_GUARDED_BY(configuration_mutex_);
};

}  // namespace sft::core
