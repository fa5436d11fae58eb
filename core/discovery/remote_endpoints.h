// The participants behind the control topics' readers and writers that Cyclone has matched with ours. One
// thread at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "core/discovery/participants.h"

namespace sft::core {

class RemoteEndpoints {
 public:
  using Handle = std::uint64_t;  ///< Cyclone's number of a reader or writer

  struct Writer {
    Participants::Guid participant{};
    std::chrono::milliseconds lease{};
  };
  std::optional<Writer> writer(Handle handle) const {
    const auto writer = writers_.find(handle);
    return writer == writers_.end() ? std::nullopt : std::optional(writer->second);
  }
  void enter(Handle handle, const Writer& writer) {
    if (writers_.size() == writers_max) writers_.clear();  // Cyclone is asked for them again
    writers_.emplace(handle, writer);
  }
  void forget_writers_of(const Participants::Guid& participant) {
    std::erase_if(writers_, [&](const auto& writer) { return writer.second.participant == participant; });
  }

  /// False if it is known, or there are too many.
  bool matched(Handle handle, const Participants::Guid& participant) {
    return matches_.size() < matches_max && matches_.emplace(handle, participant).second;
  }
  /// The participant that had that reader or writer. Nothing if it is not known.
  std::optional<Participants::Guid> unmatched(Handle handle) {
    const auto match = matches_.extract(handle);
    return match ? std::optional(match.mapped()) : std::nullopt;
  }

 private:
  static constexpr std::size_t writers_max = 4096;
  static constexpr std::size_t matches_max = 6 * 4096;

  std::map<Handle, Writer> writers_;              ///< writers of which something has come
  std::map<Handle, Participants::Guid> matches_;  ///< readers and writers of others
};

}  // namespace sft::core
