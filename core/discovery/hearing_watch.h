// HearingWatch finds links that do not hear everybody whom they ought to hear. A forged datagram with a
// sequence number far ahead makes Cyclone take all that the participant says later for old, for as long as
// both participants live; a forged withdrawal makes Cyclone forget the participant's writers. One datagram
// does not show that it is forged, but afterwards something is missing. Then the participant in whose name it
// came makes its link anew, after a complaint; if that does not help, this node makes its own link anew.
// Pure: (event, now) goes in. discovery.md has the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "core/discovery/ear.h"
#include "core/discovery/pulse.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class HearingWatch {
 public:
  enum class Missing : std::uint8_t {
    signs_of_life,  ///< Cyclone says that these come, and none is heard
    announcements,  ///< the signs of life tell of other announcements than are known
    endpoints,      ///< those of the control topics were withdrawn, although their participant stays
    everything      ///< nothing comes of a participant that is there
  };
  enum class Remedy : std::uint8_t {
    complaint,  ///< the participant is told: it makes its own link anew, which is new to everybody
    disbelief,  ///< the participant has done so: what came of it before does not count any more
    renewal     ///< our own link has to be made anew
  };
  struct Deaf {
    LinkId link = 0;
    AnnouncerId participant = 0;
    NodeId node = 0;  ///< 0: not known
    Missing missing{};
    Remedy remedy{};
  };

  /// `seed` varies the pauses before complaints: not all nodes that miss the same complain at the same time.
  explicit HearingWatch(std::uint64_t seed = 0) : random_(seed) {}

  /// Events on a link count from link_made() until link_dropped().
  /// `hears_full_signs`: full signs of life of others arrive there. If not from the beginning, this is called
  /// again when they do.
  void link_made(LinkId link, bool hears_full_signs = true) {
    links_[link].hears_full_signs = hears_full_signs;
  }
  void link_dropped(LinkId link);
  /// Another link was made in its place. The old one is listened to for a while, and does not count as deaf.
  /// But what comes by it may be somebody else's word as well.
  void link_replaced(LinkId link, LinkId by) { links_[link].replaced_by = by; }
  /// True if everybody who is heard on the link `before` is heard on the link `after`, too.
  bool is_replaced_by(LinkId before, LinkId after, Time now) const;
  void participant_came(const Speaker& speaker, Time now);
  /// The participant has the mark of nodes that understand each other, and is expected to say something.
  void participant_speaks(const Speaker& speaker, Time now) {
    if (!ears_.contains(speaker) && ear_of(speaker, now) != nullptr) came_at_ = now;
  }
  void participant_departed(const Speaker& speaker);
  /// A reader or writer of the participant's control topics is there from now on, or is not any more.
  void endpoint_matched(const Speaker& speaker, bool is_there, Time now);
  /// More is listened to from now on than before: announcements of writers, or of readers. What everybody has
  /// said of these is yet to come.
  void hears_more(Time now);
  /// An announcement or a request of the speaker came. `announced`: the node that has the endpoint.
  void heard(const Speaker& speaker, Time now, std::optional<NodeId> announced = {});
  /// A sign of life of the speaker came. `digest`: of all that it has announced and that is listened to;
  /// `lease`: of its signs of life.
  void heard_life(const Speaker& speaker, NodeId node, std::uint32_t digest, std::chrono::milliseconds lease,
                  Time now);
  /// A pulse of the speaker has come after `since`. It does not count, and this returns false, unless the
  /// speaker has named the same node by Cyclone, in a sign of life or an announcement. `digest`: as above.
  bool heard_pulse(const Speaker& speaker, const Pulse& pulse, std::uint32_t digest, Time since, Time now);
  struct Newcomers {
    Time came_at{};                ///< when a participant that is expected to say something came last
    Time met_at{};                 ///< when control endpoints met last, ours and somebody else's
    std::size_t participants = 0;  ///< that are expected to say something, on all links; some may be made up
  };
  Newcomers newcomers() const { return {came_at_, met_at_, ears_.size()}; }
  /// A node of that speaker; 0 if the speaker has not said that any lives.
  NodeId node_of(const Speaker& speaker) const {
    const auto ear = ears_.find(speaker);
    return ear == ears_.end() ? 0 : ear->second.node;
  }
  /// Cyclone says that no signs of that node's life come any more.
  void life_ended(LinkId link, NodeId node);
  /// A link was made anew because of that participant. If that does not help, and never did, then the link is
  /// not the cause.
  void tried(AnnouncerId participant) { ++participants_[participant].tries; }

  /// True if a sign of life has not come in time: it may have got lost, and frequent ones would help.
  bool is_a_sign_late(Time now) const;
  /// True if frequent signs would help to find out what is missing: at the last look something was, or a sign
  /// of life said something else than was known before it.
  bool may_miss_something() const { return may_miss_something_; }
  /// True if nothing is missing of that speaker, and only its silence could change that.
  bool is_steady(const Speaker& speaker) const {
    const auto ear = ears_.find(speaker);
    return ear != ears_.end() && ear->second.is_steady();
  }
  /// True if the last look has found that of everybody, on all links.
  bool is_steady() const;
  /// There was no need to look.
  void need_no_look(Time now) { looked_ = now; }
  /// True if look() is due: once a second, and more often while something may be missing.
  bool wants_look(Time now) const;
  /// When look() is due while something may be missing; Time::max() if nothing is.
  Time next_look_in_doubt() const;
  /// Finds what is missing. `known`: digests of what is known of each speaker. `participant_lease`: Cyclone
  /// forgets a participant of which nothing comes for so long. A renewal is told until something changes, for
  /// each link once.
  std::vector<Deaf> look(const std::map<Speaker, std::uint32_t>& known,
                         std::chrono::milliseconds participant_lease, Time now);
  /// The nodes that live, and whose announcements were all known at the last look: their signs say so.
  std::set<NodeId> nodes_known_whole(Time now) const;

 private:
  struct Link {
    Time newcomer{};  ///< when somebody came to the link
    std::optional<LinkId> replaced_by{};
    bool hears_full_signs = true;
  };
  struct Participant {
    bool has_agreed = false;  ///< everything that the participant had announced was known once
    unsigned tries = 0;
  };
  static constexpr std::size_t speakers_max = 4096;

  Ear* ear_of(const Speaker& speaker, Time now);
  std::optional<Missing> missing(const Speaker& speaker, Ear& ear,
                                 std::chrono::milliseconds participant_lease, Time now) const;
  void note_known(const std::map<Speaker, std::uint32_t>& known, Time now);
  std::optional<Remedy> remedy(const Speaker& speaker, Ear& ear, Missing missing, Time now);

  std::map<LinkId, Link> links_;
  std::map<Speaker, Ear> ears_;
  std::map<AnnouncerId, Participant> participants_;
  std::minstd_rand random_;
  Time came_at_{}, met_at_{};
  Time looked_{};
  bool looks_often_ = false;
  bool may_miss_something_ = false;
};

}  // namespace sft::core
