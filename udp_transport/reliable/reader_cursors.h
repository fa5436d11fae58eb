// The positions of the reliable readers of a writer in this process: for each reader, the next sample and
// the request in force. Uses no clock, thread or I/O.
//
// A reader's place and request only go up. A request ends at a place, because samples that were published
// before the writer knew of the next request may still be under way.
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
    std::uint64_t request = 0;       ///< the request in force; earlier ones are over
    std::uint64_t heard = 0;         ///< the newest request that the writer knows
    std::uint64_t next_request = 0;  ///< the request that begins at `next_from`
    Place next_from = no_place;
    /// Makes the next request the one in force if `place` has reached its beginning.
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
  /// Notes that the writer now serves that reader under that request or a later one.
  void heard(core::EndpointId reader, std::uint64_t request);
  /// Notes that the writer published all samples before `published` under requests that it knew of earlier.
  /// So earlier requests of the readers end there.
  void end_requests(Place published);

  /// Returns the cursor of a reader; null if the reader is unknown.
  Cursor* find(core::EndpointId reader) {
    const auto cursor = std::ranges::find(cursors_, reader, &Cursor::id);
    return cursor == cursors_.end() ? nullptr : &*cursor;
  }
  /// Returns the first place before `end` that some reader has not taken; `end` if there is none.
  Place first_not_taken(Place end) const;

 private:
  static constexpr Place no_place = std::numeric_limits<Place>::max();

  std::vector<Cursor> cursors_;
};

}  // namespace sft::udp
