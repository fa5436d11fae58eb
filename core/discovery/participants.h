// Gives numbers to DDS participants, by which the rest of the core tells them apart. Any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>

#include "core/control/control.h"
#include "core/sync/mutex.h"

namespace sft::core {

class Participants {
 public:
  using Guid = std::array<std::uint8_t, 16>;

  /// The number of a participant, never 0. A participant that comes back soon has the number that it had.
  AnnouncerId number_of(const Guid& guid) {
    const Lock lock(mutex_);
    const auto [entry, is_new] = numbers_.try_emplace(guid, last_ + 1);
    if (is_new) by_tag_.try_emplace(tag_of(guid), ++last_);
    return entry->second;
  }
  /// A short name that pulses have room for. Two participants may have the same one, but hardly do.
  static std::uint32_t tag_of(const Guid& guid) {
    std::uint32_t tag = 2'166'136'261;  // FNV-1a
    for (const std::uint8_t octet : guid) tag = (tag ^ octet) * 16'777'619;
    return tag;
  }
  /// The number of the participant of others that has that tag; of two of them, of the one that was known
  /// first.
  std::optional<AnnouncerId> tagged(std::uint32_t tag) const {
    const Lock lock(mutex_);
    const auto entry = by_tag_.find(tag);
    return entry == by_tag_.end() ? std::nullopt : std::optional(entry->second);
  }
  /// The participant that has that number. Nothing if it is forgotten.
  std::optional<Guid> guid_of(AnnouncerId number) const {
    const Lock lock(mutex_);
    const auto entry = std::ranges::find(numbers_, number, [](const auto& known) { return known.second; });
    return entry == numbers_.end() ? std::nullopt : std::optional(entry->first);
  }
  void gone(const Guid& guid) {
    const Lock lock(mutex_);
    gone_.push_back(guid);
    if (gone_.size() <= gone_max) return;
    const auto forgotten = numbers_.extract(gone_.front());
    gone_.pop_front();
    if (!forgotten) return;
    const auto tag = by_tag_.find(tag_of(forgotten.key()));
    if (tag != by_tag_.end() && tag->second == forgotten.mapped()) by_tag_.erase(tag);
  }
  /// A participant of this process, on any link.
  void add_own(const Guid& guid) {
    const Lock lock(mutex_);
    own_.insert(guid);
  }
  bool is_own(const Guid& guid) const {
    const Lock lock(mutex_);
    return own_.contains(guid);
  }

 private:
  static constexpr std::size_t gone_max = 1024;

  mutable Mutex mutex_;
  std::map<Guid, AnnouncerId> numbers_ SFT_GUARDED_BY(mutex_);
  std::map<std::uint32_t, AnnouncerId> by_tag_ SFT_GUARDED_BY(mutex_);
  std::deque<Guid> gone_ SFT_GUARDED_BY(mutex_);
  std::set<Guid> own_ SFT_GUARDED_BY(mutex_);
  AnnouncerId last_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::core
