// The reliable readers of a writer in this process: which sample each of them gets next, and under which of
// its requests. Pure.
//
// A reader's place and request only go up. A request ends at a place: samples that were published before may
// be under way for any time.
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
    Place place = 0;                 ///< the next that the reader has not got
    std::uint64_t request = 0;       ///< earlier ones are over
    std::uint64_t heard = 0;         ///< the writer knows of this one
    std::uint64_t next_request = 0;  ///< begins at next_from
    Place next_from = no_place;
    /// Goes over to the next request where that begins.
    void turn() {
      if (place < next_from) return;
      request = next_request;
      next_from = no_place;
    }
  };

  /// Sets who reads from now on. New readers begin with that place.
  void set(const std::vector<core::EndpointId>& readers, Place first);
  /// All of them go on with that place.
  void begin_at(Place place);
  /// The writer's samples are by now for that reader under that request, or a later one.
  void heard(core::EndpointId reader, std::uint64_t request);
  /// The samples before `published` are all that may be for readers under requests that the writer knew of
  /// before.
  void end_requests(Place published);

  /// Null for others.
  Cursor* find(core::EndpointId reader) {
    const auto cursor = std::ranges::find(cursors_, reader, &Cursor::id);
    return cursor == cursors_.end() ? nullptr : &*cursor;
  }
  /// The first place that one of them has not got; `end` if all have got those before it.
  Place first_not_taken(Place end) const;

 private:
  static constexpr Place no_place = std::numeric_limits<Place>::max();

  std::vector<Cursor> cursors_;
};

}  // namespace sft::udp
