// The id of the reader of a queue, and what the reader requests from the writer of the queue. The writer uses
// the id to look up whether it serves the reader, and under which conditions. The id and the requests are
// encoded in the name of the reader's port, because iceoryx passes this name on without interpreting it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/seam/transport.h"

namespace sft::shm {

struct QueueWishes {
  core::EndpointId reader = 0;  ///< the reader of the queue; 0: unknown
  bool late = false;            ///< the writer puts its retained samples into the queue before all others
  bool awaited = false;         ///< the writer waits for room in the queue, as long as it may
  bool deepest = false;         ///< as many samples may wait as the queue has places (queue_places.h)
  /// The most bytes of samples that may wait; 0: any number. The name has this rounded down to a power of
  /// two, but at least 64 KiB.
  std::uint64_t bytes_max = 0;
};

/// Returns the text behind the label in the name of the port; empty if the reader is unknown.
std::string to_text(const QueueWishes& wishes);
/// Reads the reader and the requests from the name of a port. A name without them, or with malformed ones,
/// has none.
QueueWishes parse_wishes(std::string_view port_name) noexcept;

}  // namespace sft::shm
