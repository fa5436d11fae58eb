// Remembers when each speaker was heard last. A speaker is one DDS participant on one link. Pure.
#pragma once

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
  bool speaks(const Speaker& speaker, std::chrono::milliseconds silence, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry != heard_.end() && now - entry->second.last <= silence;
  }
  /// True if the speaker has been heard for so long without a pause.
  bool has_spoken_for(const Speaker& speaker, std::chrono::milliseconds duration, Time now) const {
    const auto entry = heard_.find(speaker);
    return entry != heard_.end() && now - entry->second.since >= duration;
  }
  /// The beginning of time if the speaker was never heard.
  Time last_heard(const Speaker& speaker) const {
    const auto entry = heard_.find(speaker);
    return entry == heard_.end() ? Time{} : entry->second.last;
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
  };
  std::map<Speaker, Heard> heard_;
};

}  // namespace sft::core
