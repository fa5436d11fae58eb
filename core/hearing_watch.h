// HearingWatch tells whether each link still hears everybody whom it ought to hear. A datagram in somebody's
// name with a sequence number far ahead makes Cyclone take all that this one says later for old, for as long
// as both participants live; a withdrawal in somebody's name makes it forget his writers. Nobody can tell
// that from one datagram, but from what is missing afterwards: then the link has to be made anew. Pure:
// (event, now) goes in. discovery.md has the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/speakers.h"

namespace sft::core {

class HearingWatch {
 public:
  using Now = Speakers::Now;

  enum class Missing : std::uint8_t {
    signs_of_life,  ///< Cyclone says that they come, and none is heard
    announcements,  ///< the signs of life tell of others than are known
    endpoints,      ///< of the control topics: they were withdrawn, though their participant stays
    everything      ///< of a participant that is there
  };
  struct Deaf {
    LinkId link = 0;
    AnnouncerId participant = 0;
    NodeId node = 0;  ///< 0: not known
    Missing missing{};
  };

  /// Events on a link count from link_made() until link_dropped().
  void link_made(LinkId link) { links_.emplace(link, Link{}); }
  void link_dropped(LinkId link);
  /// Another one was made in its place. It is listened to, and does not count as deaf.
  void link_replaced(LinkId link) { links_[link].is_replaced = true; }
  /// Returns whether everybody who is heard on the link `before` is heard on the link `after`, too.
  bool is_replaced_by(LinkId before, LinkId after, Now now) const;
  /// `speaks`: it has the mark of nodes that understand each other.
  void participant_came(const Speaker& speaker, bool speaks, Now now);
  void participant_left(const Speaker& speaker);
  /// A reader or writer of it, of the control topics, is there from now on, or is not any more.
  void endpoint_matched(const Speaker& speaker);
  void endpoint_unmatched(const Speaker& speaker, Now now);
  /// An announcement or a request of it came.
  void heard(const Speaker& speaker, Now now);
  /// A sign of life of it came. `digest`: of all that it has announced; `lease`: of its signs of life.
  void heard_life(const Speaker& speaker, NodeId node, std::uint32_t digest, std::chrono::milliseconds lease,
                  Now now);
  /// Cyclone says that no signs of that node's life come any more.
  void life_ended(LinkId link, NodeId node);
  /// A link was made anew because of that one. If that does not help, and nothing ever did, then it is not
  /// the link.
  void tried(AnnouncerId participant) { ++participants_[participant].tries; }

  /// The owner calls it about twice a second. `known`: digests of what is known of each speaker.
  /// `participant_lease`: after which Cyclone forgets a participant of which nothing comes. The same is told
  /// until something changes; of each link one.
  std::vector<Deaf> look(const std::map<Speaker, std::uint32_t>& known,
                         std::chrono::milliseconds participant_lease, Now now);

 private:
  struct Link {
    Now newcomer{};  ///< when somebody was new there
    bool is_replaced = false;
  };
  struct Participant {
    bool has_agreed = false;  ///< all that it had announced was known once
    unsigned tries = 0;
  };
  struct Ear {
    Now last;  ///< when anything came, or the participant itself
    bool has_spoken = false;
    bool has_agreed = false;
    int unmatched = 0;  ///< endpoints that went, and did not come back
    Now unmatched_at{};
    NodeId node = 0;
    bool lives = false;  ///< signs of life came, and Cyclone did not say that they ended
    Now last_life{};
    std::chrono::milliseconds lease{};
    std::uint32_t told = 0;   ///< digests
    std::uint32_t known = 0;  ///< when it was looked at last
    Now agreed{};             ///< both were equal, or what is known changed
    std::optional<Now> overdue_since{};
  };
  static constexpr std::size_t speakers_max = 4096;

  Ear* ear_of(const Speaker& speaker, Now now);
  std::optional<Missing> missing(const Speaker& speaker, Ear& ear,
                                 std::chrono::milliseconds participant_lease, Now now) const;

  std::map<LinkId, Link> links_;
  std::map<Speaker, Ear> ears_;
  std::map<AnnouncerId, Participant> participants_;
  Now looked_{};
};

}  // namespace sft::core
