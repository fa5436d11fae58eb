// Pulses that say what their speakers have said before, while all is steady. There a pulse tells nothing but
// when it came, so it waits here, in one place of memory for all, until somebody has to know. In calm most
// pulses are such ones, and to tell each of them to all who keep account of its speaker was a third of what
// an idle node in a crowd took. discovery.md says when all is steady. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/hearing_watch.h"
#include "core/discovery/link_merge.h"
#include "core/discovery/pulse.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class RepeatedPulses {
 public:
  /// What a speaker says of one of its nodes.
  struct Voice {
    Speaker speaker;
    Pulse pulse;
    std::uint32_t digest = 0;  ///< of what the speaker has announced and is listened to
  };

  /// A pulse waits for so long at most until it is told.
  static constexpr std::chrono::seconds waits_max{9};

  /// More may be made up. Then it is not steady.
  static constexpr std::size_t voices_max = 4096;

  /// Notes a pulse that was told, and came after `since`.
  void told(const Voice& voice, Time since, Time now);
  /// All is steady from now on, until end(), if these are all who speak: `living` nodes live, and so many
  /// speakers are heard. Otherwise it is not steady. REQUIRES: nothing waits.
  void begin(std::size_t living, std::size_t speakers, Time now);
  bool is_steady() const { return is_steady_; }
  /// True if all is steady, and the pulse, which has come after `since`, is a repetition: it waits. It may
  /// tell of more full signs than before if one of them has come, maybe before pulses that were sent earlier:
  /// pulses wait for a look to be heard, and full signs do not.
  bool waits(LinkId link, const Pulse& pulse, Time since, Time now);
  /// True if all is steady, and nothing has changed but the number of full signs.
  bool is_as_before(LinkId link, const Pulse& pulse) const;
  /// A full sign has come. True if all is steady, and the speaker says the same of that node as before.
  bool full_sign_is_as_before(const Speaker& speaker, NodeId node, std::uint32_t digest);
  /// All that may have changed with time was found.
  void looked(Time now) { looked_at_ = now; }
  /// True if all is steady, everybody has spoken lately, and nothing waits for too long: there is nothing to
  /// find out.
  bool need_no_look(Time now) const;

  /// Tells all that waits.
  void tell(HearingWatch& hearing, LinkMerge& merge);
  /// Tells what waits of that node, of which something else is told next. If that is not as before, and all
  /// was steady, this is the end.
  void make_way(NodeId node, bool is_as_before, HearingWatch& hearing, LinkMerge& merge);
  /// Something else happens than that nodes say that they live: tells all that waits, and forgets all.
  void end(HearingWatch& hearing, LinkMerge& merge);

 private:
  struct Known {
    Voice voice;
    Time since{}, last{};  ///< the last pulse came between these
    bool waits = false;
    bool full_sign_came = false;  ///< of which no pulse has told yet
  };
  /// In the order of nodes, links and participants. It is one piece of memory, of which a look needs all.
  std::vector<Known> voices_;
  bool is_steady_ = false;
  Time looked_at_{};  ///< nothing waits since before
};

}  // namespace sft::core
