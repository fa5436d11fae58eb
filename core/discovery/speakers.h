// Remembers when each speaker was heard last. A speaker is one DDS participant on one link. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <utility>

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
  /// The speaker gives pulses, whatever they count for. These wait until they are looked for: how long the
  /// speaker has been silent is judged as of the last time when that was done.
  void pulse_came(const Speaker& speaker, Time now) { pulsed_[speaker] = now; }
  bool gives_pulses(const Speaker& speaker) const { return pulsed_.contains(speaker); }
  /// Pulses of the speaker have come until then without a pause.
  void pulses_came_until(const Speaker& speaker, Time last) {
    pulse_came(speaker, last);
    if (const auto entry = heard_.find(speaker); entry != heard_.end())
      entry->second.last = std::max(entry->second.last, last);
  }
  /// All pulses that had come until then have been heard.
  void pulses_heard(Time now) { pulses_heard_ = now; }
  bool speaks(const Speaker& speaker, std::chrono::milliseconds silence, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry != heard_.end() && silent_for(*entry, now) <= silence;
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
    return entry == heard_.end() ? Time{} : now - silent_for(*entry, now);
  }
  void forget_link(LinkId link) {
    const auto is_of_link = [&](const auto& entry) { return entry.first.link == link; };
    std::erase_if(heard_, is_of_link);
    std::erase_if(pulsed_, is_of_link);
  }
  void forget_before(Time time) {
    std::erase_if(heard_, [&](const auto& entry) { return entry.second.last < time; });
    std::erase_if(pulsed_, [&](const auto& entry) { return entry.second < time; });
  }

 private:
  struct Heard {
    Time last;
    Time since;
  };
  Time::duration silent_for(const std::pair<const Speaker, Heard>& entry, Time now) const {
    const Time last = entry.second.last;
    return (gives_pulses(entry.first) ? std::max(last, std::min(now, pulses_heard_)) : now) - last;
  }

  std::map<Speaker, Heard> heard_;
  std::map<Speaker, Time> pulsed_;  // when last
  Time pulses_heard_{};
};

}  // namespace sft::core
