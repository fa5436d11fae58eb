// The id of the reader of a queue, and the reader's requests to the writer of the queue. With the id, the
// writer finds out whether it serves the reader, and under which conditions. The id and the requests are
// encoded in the name of the reader's port, because iceoryx passes this name on without interpreting it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/seam/transport.h"

namespace sft::shm {

struct QueueWishes {
  core::EndpointId reader = 0;  ///< the reader of the queue; 0: unknown
  /// True if the reader requests the retained samples of the writer before all other samples.
  bool late = false;
  /// True if the reader requests that the writer waits for room in the queue, as long as the writer's
  /// timeout allows.
  bool awaited = false;
  /// True if the queue has no spare place: samples may wait in all its places (queue_places.h).
  bool deepest = false;
  /// The limit of the bytes of waiting samples; 0: no limit. The name contains this limit rounded down to a
  /// power of two, but at least 64 KiB.
  std::uint64_t bytes_max = 0;
};

/// Returns the text that follows the label in the name of the port; empty if the reader is unknown.
std::string to_text(const QueueWishes& wishes);
/// Reads the reader and the requests from the name of a port. The result is empty if the name contains no
/// requests or malformed requests.
QueueWishes parse_wishes(std::string_view port_name) noexcept;

}  // namespace sft::shm
