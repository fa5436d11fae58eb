// Remembers when each speaker was heard last. A speaker is one DDS participant on one link. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <compare>
#include <cstdint>
#include <map>

#include "core/control/control.h"
#include "core/platform/clock.h"

namespace sft::core {

using LinkId = std::uint32_t;

struct Speaker {
  LinkId link = 0;
  AnnouncerId participant = 0;
  friend auto operator<=>(const Speaker&, const Speaker&) = default;
};

class Speakers {
 public:
  /// After a pause that is longer than `silence` the speaker counts as having begun to speak anew.
  void heard(const Speaker& speaker, std::chrono::milliseconds silence, Time now) {
    const auto [entry, is_new] = heard_.try_emplace(speaker, Heard{now, now});
    if (!is_new && now - entry->second.last > silence) entry->second.since = now;
    entry->second.last = now;
  }
  /// The speaker gives pulses. These wait until they are looked for: how long the speaker has been silent is
  /// judged as of the last time when that was done.
  void gives_pulses(const Speaker& speaker) {
    const auto entry = heard_.find(speaker);
    if (entry != heard_.end()) entry->second.by_pulses = true;
  }
  /// All pulses that had come until then have been heard.
  void pulses_heard(Time now) { pulses_heard_ = now; }
  bool speaks(const Speaker& speaker, std::chrono::milliseconds silence, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry != heard_.end() && silent_for(entry->second, now) <= silence;
  }
  /// True if the speaker has been heard for so long without a pause.
  bool has_spoken_for(const Speaker& speaker, std::chrono::milliseconds duration, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry != heard_.end() && now - entry->second.since >= duration;
  }
  /// When the speaker may have spoken last, as far as can be known. The beginning of time if the speaker was
  /// never heard.
  Time last_heard(const Speaker& speaker, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry == heard_.end() ? Time{} : now - silent_for(entry->second, now);
  }
  void forget(const Speaker& speaker) { heard_.erase(speaker); }
  void forget_link(LinkId link) {
    std::erase_if(heard_, [&](const auto& entry) { return entry.first.link == link; });
  }
  void forget_before(Time time) {
    std::erase_if(heard_, [&](const auto& entry) { return entry.second.last < time; });
  }

 private:
  struct Heard {
    Time last;
    Time since;
    bool by_pulses = false;
  };
  Time::duration silent_for(const Heard& heard, Time now) const {
    return (heard.by_pulses ? std::max(heard.last, std::min(now, pulses_heard_)) : now) - heard.last;
  }

  std::map<Speaker, Heard> heard_;
  Time pulses_heard_{};
};

}  // namespace sft::core
