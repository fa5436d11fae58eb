// The positions of a writer's reliable readers in this process. Each reader has the place of its next
// sample, and the request in force. Uses no clock, thread or I/O.
//
// A reader's place and request never decrease. A request ends at a certain place, because samples that were
// published before the writer received the next request may still be under way.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/seam/transport.h"

namespace sft::udp {

class ReaderCursors {
 public:
  using Place = std::uint64_t;

  struct Cursor {
    core::EndpointId id = 0;
    Place place = 0;                 ///< place of the next sample for the reader
    std::uint64_t request = 0;       ///< the request in force; earlier requests have ended
    std::uint64_t heard = 0;         ///< the newest request that the writer has received
    std::uint64_t next_request = 0;  ///< the request that begins at `next_from`
    Place next_from = no_place;
    /// Puts the next request in force if `place` has reached its beginning.
    void turn() {
      if (place < next_from) return;
      request = next_request;
      next_from = no_place;
    }
  };

  /// Sets the readers. New readers begin with place `first`.
  void set(const std::vector<core::EndpointId>& readers, Place first);
  /// Makes all readers continue with that place.
  void begin_at(Place place);
  /// Notes that the writer now serves that reader under `request` or a later request.
  void heard(core::EndpointId reader, std::uint64_t request);
  /// Notes that the writer has published samples up to the place `published`, so that samples from there on
  /// are published under the requests that it has received by now. So earlier requests end at that place.
  void end_requests(Place published);

  /// Returns the cursor of a reader; null if the reader is unknown.
  Cursor* find(core::EndpointId reader) {
    const auto cursor = std::ranges::find(cursors_, reader, &Cursor::id);
    return cursor == cursors_.end() ? nullptr : &*cursor;
  }
  /// Returns the first place before `end` whose sample some reader has not taken; `end` if there is none.
  Place first_not_taken(Place end) const;

 private:
  static constexpr Place no_place = std::numeric_limits<Place>::max();

  std::vector<Cursor> cursors_;
};

}  // namespace sft::udp
