// The readers, or writers, of others that one of our endpoints of a control topic has met. One thread at a
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "core/discovery/control_word.h"
#include "core/discovery/participants.h"

namespace sft::core {

class Matches {
 public:
  using Handle = std::uint64_t;  ///< Cyclone's number of a reader or writer

  /// Returns what is to be told of it: nothing if it is known, or if there are too many.
  std::optional<ControlWord> met(Handle handle, const Participants::Guid& participant) {
    if (matches_.size() == matches_max || !matches_.emplace(handle, participant).second) return {};
    return ControlWord{participant, EndpointMet{}};
  }
  /// The same. Nothing if it was not known.
  std::optional<ControlWord> gone(Handle handle) {
    const auto match = matches_.extract(handle);
    return match ? std::optional(ControlWord{match.mapped(), EndpointGone{}}) : std::nullopt;
  }

 private:
  static constexpr std::size_t matches_max = 3 * 4096;  // each of so many nodes has one for each topic

  std::map<Handle, Participants::Guid> matches_;
};

}  // namespace sft::core
