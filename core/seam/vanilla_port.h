// The port by which a publisher sends to unmodified readers of DDS and ROS 2, and the samples that a
// subscriber gets from unmodified writers. Such readers take whole samples only, and DDS discovers and
// matches them. So they have no routes: the publisher passes each sample to this port once, whatever the
// number of readers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::core {

/// A sample of an unmodified writer.
struct VanillaArrival {
  EndpointId writer = 0;
  std::uint64_t sequence = 0;  ///< the number that the writer has given to the sample; 0: unknown
  /// The stamp of the writer; 0 or less: the sample has no stamp, which DDS allows
  std::int64_t source_stamp_ns = 0;
  /// Has all fields, was checked, and is shared with other readers; empty: the sample could not be read
  SampleHandle sample{};
};

class VanillaPort {
 public:
  virtual ~VanillaPort() = default;

  /// Queues the sample to be sent, and returns at once. The sample must have all fields, and must not
  /// change while the port keeps its handle. If too many samples are queued, the oldest ones are dropped.
  /// Called by the publisher's thread.
  virtual void send(const SampleHandle& sample) noexcept = 0;

  // The following functions are called by the agent.

  /// Takes the samples that the publisher had retained when it began to send by this port. They are sent
  /// before the samples that are passed to send(). Some samples may be passed to both functions. Must be
  /// called only once.
  virtual void begin_with(std::vector<SampleHandle> retained) = 0;

  /// Returns the present number of readers. Any thread may call this.
  virtual std::size_t readers() const noexcept = 0;
};

}  // namespace sft::core
