// The participants behind the control topics' readers and writers that Cyclone has matched with ours. Any
// thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "core/control/control.h"
#include "core/sync/mutex.h"

namespace sft::core {

class RemoteEndpoints {
 public:
  using Handle = std::uint64_t;  ///< Cyclone's number of a reader or writer

  struct Writer {
    AnnouncerId participant = 0;  ///< 0: our own
    std::chrono::milliseconds lease{};
  };
  std::optional<Writer> writer(Handle handle) const {
    const Lock lock(mutex_);
    const auto writer = writers_.find(handle);
    return writer == writers_.end() ? std::nullopt : std::optional(writer->second);
  }
  void enter(Handle handle, const Writer& writer) {
    const Lock lock(mutex_);
    if (writers_.size() == writers_max) writers_.clear();  // Cyclone is asked for them again
    writers_.emplace(handle, writer);
  }
  void forget_writers_of(AnnouncerId participant) {
    const Lock lock(mutex_);
    std::erase_if(writers_, [&](const auto& writer) { return writer.second.participant == participant; });
  }

  void matched(Handle handle, AnnouncerId participant) {
    const Lock lock(mutex_);
    if (matches_.size() < matches_max) matches_.emplace(handle, participant);
  }
  /// The participant that had that reader or writer; 0 if it is not known.
  AnnouncerId unmatched(Handle handle) {
    const Lock lock(mutex_);
    const auto match = matches_.extract(handle);
    return match ? match.mapped() : 0;
  }

 private:
  static constexpr std::size_t writers_max = 4096;
  static constexpr std::size_t matches_max = 6 * 4096;  // three topics, a reader and a writer of each

  mutable Mutex mutex_;
  std::map<Handle, Writer> writers_ SFT_GUARDED_BY(mutex_);       ///< writers of which something has come
  std::map<Handle, AnnouncerId> matches_ SFT_GUARDED_BY(mutex_);  ///< readers and writers of others
};

}  // namespace sft::core
