// Hears all links: merges what they bring, passes the news on to the nodes of this process, and notices whom
// a link does not hear. Cyclone's threads bring what comes, several at once; the functions below "One thread"
// are called by one thread at a time. A mutex guards everything; it is not held while news are passed on.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/discovery/discovery_link.h"
#include "core/discovery/hearing_watch.h"
#include "core/discovery/link_merge.h"
#include "core/discovery/news_desk.h"
#include "core/discovery/ordered_delivery.h"
#include "core/discovery/other_releases.h"
#include "core/discovery/process_nodes.h"
#include "core/discovery/repeated_pulses.h"
#include "core/discovery/sign_pace.h"
#include "core/platform/clock.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// Larger than usual: it has a function for each event that a listener is told of.
class DiscoveryEar final : public LinkListener {
 public:
  /// `signs`: those of our nodes.
  explicit DiscoveryEar(const LifeSigns& signs, ReadTime time = &std::chrono::steady_clock::now);

  // One thread. News that come of these functions wait for pass_on(), which the caller calls without a lock.

  /// Calls act(nodes, merge) with the nodes of this process, and what is known of others. Claims of others in
  /// the name of own endpoints are passed on unchanged.
  template <class Act>
  auto with_nodes(Act act) {
    const Lock lock(mutex_);
    pulses_.end(hearing_, merge_);
    return act(nodes_here_, merge_);
  }
  void pass_on();
  /// A node of this process says that it lives.
  void own_sign_given(const std::shared_ptr<NodeListener>& by, const Assertion& sign, Time now);
  /// Announcements of that role are listened to from now on, on all links.
  void hears(Role role, Time now);
  /// True if a participant was heard for the first time since this was called last.
  bool take_newcomer() { return newcomer_.exchange(false); }
  /// Any thread.
  HearingWatch::Newcomers newcomers() const {
    const Lock lock(mutex_);
    return hearing_.newcomers();
  }
  struct AfterTick {
    SignPace signs;                     ///< whether signs of life have to be frequent
    std::chrono::milliseconds pause{};  ///< until the next tick
  };
  AfterTick tick(Time now);
  bool pulse_came(LinkId link, const Pulse& pulse, const Participants& participants, Time since) override;
  /// Pulses that come until the next look do not wait.
  void tell_every_pulse();
  /// All pulses that had come until then have been told.
  void pulses_heard(Time now);

  /// Before it is opened; otherwise as HearingWatch::link_made().
  void link_expected(LinkId link, bool hears_full_signs);
  void link_opened(LinkId link, const LinkSpec& spec);
  /// The link is closed, or could not be opened. `is_replaced`: another link was made in its place before.
  void link_dropped(LinkId link, bool is_replaced, Time now);
  void link_replaced(LinkId link, LinkId by);
  /// True if everybody who is heard on one link is heard on the other one, too.
  bool is_replaced(LinkId link, LinkId by, Time now) const;

  /// Nodes with other versions of the control topics, for people, if there are new ones.
  std::optional<std::string> take_other_releases(Time now);

  struct DeafLink {
    HearingWatch::Deaf deaf;
    std::string why;  ///< for people
  };
  struct Deafness {
    /// Links on which others complain that they have heard something else in our name than we say, and who
    /// complains.
    std::map<LinkId, std::string> complaints_about_us;
    std::map<LinkId, std::vector<AnnouncerId>> complaints;  ///< to be made, about these participants
    std::vector<DeafLink> renewals;                         ///< links that have to be made anew
    Time next_look = Time::max();  ///< at the latest; Time::max() if it need not be soon
  };
  /// Looks for participants that are there but not heard. `participant_lease`: as of HearingWatch::look().
  Deafness look_for_deafness(std::chrono::milliseconds participant_lease, Time now);
  /// A link was made anew because of that.
  void was_renewed_for(const HearingWatch::Deaf& deaf);

  // LinkListener: Cyclone's threads.
  void endpoint_came(const Speaker& speaker, Endpoint endpoint) override;
  void endpoint_withdrawn(const Speaker& speaker, EndpointId id) override;
  void endpoint_unheard(LinkId link, EndpointId id) override;
  void request_came(const Speaker& speaker, Request request) override;
  void assertion_came(const Speaker& speaker, Assertion assertion, std::chrono::milliseconds lease) override;
  void node_unheard(LinkId link, NodeId id) override;
  void participant_came(const Speaker& speaker) override;
  void participant_speaks(const Speaker& speaker) override;
  void other_release_seen(const Speaker& speaker, std::uint32_t version) override;
  void complaint_came(const Speaker& speaker) override;
  void endpoint_matched(const Speaker& speaker, bool is_there) override;
  void participant_departed(const Speaker& speaker) override;
  void sample_malformed(std::string why) override;

 private:
  void pass_on_news(Lock& lock) SFT_REQUIRES(mutex_);

  std::atomic<bool> newcomer_{false};

  const ReadTime time_;
  mutable Mutex mutex_;
  LinkMerge merge_ SFT_GUARDED_BY(mutex_);
  HearingWatch hearing_ SFT_GUARDED_BY(mutex_);
  RepeatedPulses pulses_ SFT_GUARDED_BY(mutex_);
  ProcessNodes nodes_here_ SFT_GUARDED_BY(mutex_);
  std::set<Role> roles_ SFT_GUARDED_BY(mutex_);  ///< announcements of these are listened to
  SignPace sign_pace_ SFT_GUARDED_BY(mutex_);
  OtherReleases other_releases_ SFT_GUARDED_BY(mutex_);
  std::vector<Speaker> complaints_ SFT_GUARDED_BY(mutex_);  ///< participants that complain about us
  NewsDesk::Links specs_ SFT_GUARDED_BY(mutex_);            ///< of the links that are open
  OrderedDelivery<AddressedNews> delivery_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
