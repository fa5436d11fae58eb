// Discovery as the nodes of a process share it, if they ask for the same: one participant on each link, one
// writer and one reader of each control topic, and one memory of what others say. A process costs others no
// more than one node then, but for what its nodes announce. Any thread.
#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/discovery/dds_config.h"
#include "core/discovery/discovery.h"
#include "core/discovery/discovery_ear.h"
#include "core/discovery/greetings.h"
#include "core/discovery/link_set.h"
#include "core/discovery/own_announcements.h"
#include "core/discovery/process_nodes.h"
#include "core/discovery/sign_pace.h"
#include "core/platform/clock.h"
#include "core/platform/network_watch.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// Decides which links are wanted and when others are greeted, and describes all that to the user.
class JointDiscovery {
 public:
  /// The one that nodes of this process with equal options have, or a new one.
  static Result<std::shared_ptr<JointDiscovery>> of(const DiscoveryOptions& options);

  JointDiscovery(DdsConfig config, const ThreadSettings& threads);
  Result<void> open(std::uint32_t domain);
  JointDiscovery(const JointDiscovery&) = delete;
  JointDiscovery& operator=(const JointDiscovery&) = delete;

  LifeSigns life_signs() const { return life_signs_; }
  bool is_calm(Time now) const;
  Discovery::Configuration configuration() const;

  /// A report is told to a node on its own thread. It names a function of the listener, and has the text.
  struct Report {
    void (DiscoveryListener::*tell)(const std::string& text) = nullptr;
    std::string text;
  };
  /// A node of this process.
  struct Seat {
    explicit Seat(DiscoveryListener& listener) : member(std::make_shared<NodeListener>(listener)) {}
    const std::shared_ptr<NodeListener> member;
    // The rest is the discovery's, under its lock.
    Discovery::Awaited awaits;
    std::vector<Report> reports{};  ///< that the node is told when it looks after discovery next
  };
  /// Seats are used by one thread at a time, and until leave().
  Seat& join(DiscoveryListener& listener);
  /// Withdraws what the node has announced. When it returns, its listener is not called any more.
  void leave(Seat& seat);

  // These functions do what those of Discovery do.
  Result<void> hear(Seat& seat, Role role);
  std::vector<Discovery::KnownPublisher> publishers_of(std::string_view type_name);
  Result<void> announce(Seat& seat, const Endpoint& endpoint);
  void withdraw(EndpointId id);
  Result<void> send(const Request& request);
  void assert_liveliness(Seat& seat, const Assertion& assertion);
  auto newcomers() const { return ear_.newcomers(); }
  Time look_after(Seat& seat, Time now, const Discovery::Awaited& awaited);

 private:
  Result<void> join_the_program(std::uint32_t domain) SFT_REQUIRES(mutex_);
  void look_at_interfaces(Time now) SFT_REQUIRES(mutex_);
  void give_up(Time now) SFT_REQUIRES(mutex_);
  void use_interfaces(Time now) SFT_REQUIRES(mutex_);
  Time look_at_peers(Time now) SFT_REQUIRES(mutex_);
  Result<void> use(const DesiredLinks& desired, Time now) SFT_REQUIRES(mutex_);
  Result<void> hear_on_links(Role role) SFT_REQUIRES(mutex_);
  void withdraw_from_links(EndpointId id) SFT_REQUIRES(mutex_);
  void told_news() SFT_REQUIRES(mutex_);
  void write(Assertion assertion, bool is_wanted, Time now) SFT_REQUIRES(mutex_);
  Time look_after_links(Time now) SFT_REQUIRES(mutex_);
  Time mend_links(Time now) SFT_REQUIRES(mutex_);
  bool renew(LinkId id, const std::string& why, Time now) SFT_REQUIRES(mutex_);
  void greet_on_new_links(Time now) SFT_REQUIRES(mutex_);

  const DdsConfig config_;
  const LifeSigns life_signs_;

  /// Held while control samples are written, so that all links get them in one order, while pulses are given
  /// and taken, which waits for nothing, and while links are made and closed. Agents take it, and who opens
  /// or closes a node; nobody who holds another lock.
  Mutex mutex_;
  /// Interfaces, and deaf links, unless the domain is the program's own.
  bool watches_ SFT_GUARDED_BY(mutex_) = true;
  NetworkWatch watch_ SFT_GUARDED_BY(mutex_);
  Greetings greetings_ SFT_GUARDED_BY(mutex_){std::chrono::steady_clock::now()};
  struct Look {
    const Seat* by = nullptr;
    Time at{};
  };
  Look last_look_ SFT_GUARDED_BY(mutex_);
  struct Due {
    Time look_at_interfaces{}, merge{};
  };
  Due next_ SFT_GUARDED_BY(mutex_);
  std::vector<HostInterface> interfaces_ SFT_GUARDED_BY(mutex_);
  PeerAddresses peers_ SFT_GUARDED_BY(mutex_);
  struct FrequentSigns {
    Time until{}, next{};
  };
  FrequentSigns after_renewal_ SFT_GUARDED_BY(mutex_);
  std::list<Seat> seats_ SFT_GUARDED_BY(mutex_);
  OwnAnnouncements own_ SFT_GUARDED_BY(mutex_);
  SignPace own_pace_ SFT_GUARDED_BY(mutex_);  ///< after what the nodes of this process have told
  SignPace pace_ SFT_GUARDED_BY(mutex_);      ///< after what they have heard, at the last tick

  /// From this time on all is calm, after what this process has told and heard. Agents ask for it with each
  /// tick.
  std::atomic<Time> calm_from_{};

  mutable Mutex configuration_mutex_;
  Discovery::Configuration configuration_ SFT_GUARDED_BY(configuration_mutex_);

  DiscoveryEar ear_;
  LinkSet links_ SFT_GUARDED_BY(mutex_);  ///< ends first: its threads use the ear
};

}  // namespace sft::core
