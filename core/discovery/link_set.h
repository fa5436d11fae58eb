// The links of this process: opens those that are wanted and closes others, makes a link anew that is deaf,
// and keeps the replaced one until everybody is heard on the new one. One thread at a time.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/dds_config.h"
#include "core/discovery/dds_domain.h"
#include "core/discovery/desired_links.h"
#include "core/discovery/discovery_ear.h"
#include "core/discovery/discovery_link.h"
#include "core/discovery/full_signs.h"
#include "core/discovery/own_announcements.h"
#include "core/discovery/participants.h"
#include "core/discovery/renewal_pace.h"
#include "core/platform/clock.h"
#include "sft/options.h"

namespace sft::core {

class LinkSet {
 public:
  struct Settings {
    DdsConfig config;
    ThreadSettings threads;
    LifeSigns life_signs;
  };
  /// All outlive this object. `own` is written to each link that is opened.
  LinkSet(Settings settings, const OwnAnnouncements& own, DiscoveryEar& ear)
      : settings_(std::move(settings)), own_(own), ear_(ear) {}
  /// Waits a moment until others have what was written.
  ~LinkSet();
  LinkSet(const LinkSet&) = delete;
  LinkSet& operator=(const LinkSet&) = delete;

  /// Opens one link in a DDS domain that the program itself has configured.
  Result<void> join(std::uint32_t domain);
  /// Opens the links that are wanted, and closes others after that. The error is that of the first link that
  /// could not be opened; such links are tried again by the next call. A link is made anew if it has to
  /// ask other addresses than before, as `hosts` has them.
  Result<void> use(const std::vector<LinkSpec>& wanted, const KnownHosts& hosts, Time now);
  /// Makes a link anew, for a reason that take_renewals() tells. Returns false if that is too early, or
  /// fails.
  bool renew(LinkId id, const std::string& why, Time now);
  /// The renewals since the last call, also those that failed, for people.
  std::vector<std::string> take_renewals() { return std::exchange(told_renewals_, {}); }
  /// Listens to announcements of that role on all links, also on those that are opened later. To be called
  /// again after an error.
  Result<void> hear(Role role);
  /// Lets full signs of life go and come on all links, and not only where they have waited for long enough.
  void exchange_full_signs(Time now);
  /// Lets them do so where that is due. Returns when this has to be
  /// called again; Time::max() if it need not.
  Time exchange_due_full_signs(const HearingWatch::Newcomers& newcomers, Time now);
  /// Gives a sign of life on all links: a full one where a pulse will not do. `is_wanted`: frequent ones are.
  void write(const Assertion& sign, bool is_wanted, Time now);
  /// The node does not live any more, though its process does.
  void end_life(NodeId node);
  /// Hears the pulses that have come since the last call. Returns false if one of them counts for nothing.
  bool hear_pulses(Time now);
  /// Closes replaced links that are not needed any more.
  void retire(Time now);
  /// Complains on one link about these participants.
  void complain(LinkId id, const std::vector<AnnouncerId>& participants);

  bool empty() const { return links_.empty(); }
  std::vector<LinkSpec> specs() const;
  /// Links that could not be opened, and why.
  const std::vector<std::string>& failures() const { return failures_; }
  /// Complaints of Cyclone about the configuration.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Calls act(link) for every link; returns the first error.
  template <class Act>
  Result<void> on_each(Act act) {
    Result<void> result;
    each([&](DiscoveryLink& link) {
      if (Result<void> done = act(link); !done && result) result = std::move(done);
    });
    return result;
  }
  template <class Use>
  void each(Use use) {
    for (const auto& [spec, link] : links_) use(*link.link);
    for (const RetiringLink& retiring : retiring_) use(*retiring.link.link);
  }

 private:
  struct OpenLink {
    LinkId id = 0;
    std::string config;                           ///< the text that `domain` was made with
    std::shared_ptr<const CycloneDomain> domain;  ///< null if the program has made it
    std::unique_ptr<DiscoveryLink> link;
    std::optional<Time> waits_since{};  ///< with full signs of life; nothing once they go and come
  };
  struct RetiringLink {
    OpenLink link;
    LinkId replaced_by = 0;
    Time since;
  };

  Result<OpenLink> make(const LinkSpec& spec, const OpenLink* instead_of);
  void open_missing(const std::vector<LinkSpec>& wanted, Result<void>& result, Time now);
  void replace(OpenLink& link, OpenLink successor, Time now);
  template <class IsDue>
  void exchange_full_signs_if(IsDue is_due, Time now);
  void drop(OpenLink dropped, bool is_replaced, Time now);
  std::map<LinkSpec, OpenLink>::iterator find(LinkId id);

  const Settings settings_;
  const OwnAnnouncements& own_;
  DiscoveryEar& ear_;
  Participants participants_;
  KnownHosts hosts_;
  std::set<Role> heard_;
  FullSigns full_signs_;
  Time heard_pulses_at_{};
  LinkId links_made_ = 0;
  std::vector<std::string> failures_;
  std::vector<std::string> warnings_;
  std::map<LinkSpec, RenewalPace> renewals_;
  std::vector<std::string> told_renewals_;
  std::deque<RetiringLink> retiring_;  ///< others still know us by these; the oldest first
  std::map<LinkSpec, OpenLink> links_;
};

}  // namespace sft::core
