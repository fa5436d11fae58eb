// Whether each link still hears whom it ought to hear. A datagram in somebody's name with a sequence number
// far ahead makes Cyclone take all that this one says later for old, for as long as both participants live; a
// withdrawal in somebody's name makes it forget his writers. Nobody can tell that from one datagram, but from
// what is missing afterwards: then the link has to be made anew. Pure: (event, now) goes in. discovery.md has
// the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/speakers.h"

namespace sft::core {

class HearingWatch {
 public:
  using Now = Speakers::Now;

  enum class Missing : std::uint8_t {
    signs_of_life,  ///< Cyclone says that they come, and none is heard
    announcements,  ///< the signs of life tell of others than are known
    everything      ///< of a participant that is there
  };
  struct Deaf {
    LinkId link = 0;
    AnnouncerId participant = 0;
    NodeId node = 0;  ///< 0: not known
    Missing missing{};
  };

  /// What is heard on links that were not made, or were dropped, does not count.
  void link_made(LinkId link) { links_.emplace(link, Now{}); }
  void link_dropped(LinkId link);
  /// `speaks`: it has the mark of nodes that understand each other.
  void participant_came(const Speaker& speaker, bool speaks, Now now);
  void participant_left(const Speaker& speaker);
  /// An announcement or a request of it came.
  void heard(const Speaker& speaker, Now now);
  /// A sign of life of it came. `digest`: of all that it has announced; `lease`: of its signs of life.
  void heard_life(const Speaker& speaker, NodeId node, std::uint32_t digest, std::chrono::milliseconds lease,
                  Now now);
  /// Cyclone says that no signs of that node's life come any more.
  void life_ended(LinkId link, NodeId node);
  /// A link was made anew because of that one. If that does not help, then it is not the link.
  void tried(AnnouncerId participant) { ++tries_[participant]; }

  /// To be asked about twice a second. `known`: digests of what is known of each speaker.
  /// `participant_lease`: after which Cyclone forgets a participant of which nothing comes. The same is told
  /// until something changes; of each link one.
  std::vector<Deaf> look(const std::map<Speaker, std::uint32_t>& known,
                         std::chrono::milliseconds participant_lease, Now now);

 private:
  struct Ear {
    Now last;  ///< when anything came, or the participant itself
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

  std::map<LinkId, Now> links_;  ///< and when somebody was new there
  std::map<Speaker, Ear> ears_;
  std::map<AnnouncerId, unsigned> tries_;  ///< since all of that participant was known
  Now looked_{};
};

}  // namespace sft::core
