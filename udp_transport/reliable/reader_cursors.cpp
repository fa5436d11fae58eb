#include "udp_transport/reliable/reader_cursors.h"

#include <utility>

namespace sft::udp {

void ReaderCursors::set(const std::vector<core::EndpointId>& readers, Place first) {
  const auto before = std::exchange(cursors_, {});
  for (const core::EndpointId reader : readers) {
    const auto known = std::ranges::find(before, reader, &Cursor::id);
    cursors_.push_back(known == before.end() ? Cursor{.id = reader, .place = first} : *known);
  }
}

void ReaderCursors::begin_at(Place place) {
  for (Cursor& cursor : cursors_) cursor.place = place;
}

void ReaderCursors::heard(core::EndpointId reader, std::uint64_t request) {
  if (Cursor* cursor = find(reader)) cursor->heard = std::max(cursor->heard, request);
}

/// A reader's requests end one after the other: the end of a request is set only after the end of the
/// previous request was reached.
void ReaderCursors::end_requests(Place published) {
  for (Cursor& cursor : cursors_) {
    cursor.turn();
    if (cursor.heard <= cursor.request || cursor.next_from != no_place) continue;
    cursor.next_request = cursor.heard;
    cursor.next_from = published;
  }
}

ReaderCursors::Place ReaderCursors::first_not_taken(Place end) const {
  for (const Cursor& cursor : cursors_) end = std::min(end, cursor.place);
  return end;
}

}  // namespace sft::udp
