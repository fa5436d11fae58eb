// The id of the reader of a queue, by which the writer finds whether it serves the reader and under which
// conditions, and the requests that the reader makes to the writer of the queue. They travel in the name of
// the reader's port: iceoryx passes the name on and does not read it.
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
  bool deepest = false;         ///< as many samples wait as the queue has places (queue_places.h)
  /// The most bytes of samples that wait; 0: any number. What is written is a power of two, not greater than
  /// this unless this is less than 64 KiB.
  std::uint64_t bytes_max = 0;
};

/// Returns what stands behind the label of the port; empty if the reader is unknown.
std::string to_text(const QueueWishes& wishes);
/// Reads the reader and the requests from the name of a port. A name without them, or with malformed ones,
/// has none.
QueueWishes parse_wishes(std::string_view port_name) noexcept;

}  // namespace sft::shm
