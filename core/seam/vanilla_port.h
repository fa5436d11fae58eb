// The sending end for the readers of a topic that are nodes of DDS or ROS 2, and know nothing of SFT. They
// take whole samples only, they are found and matched by DDS, and there are no routes to them: a publisher
// hands each sample over once, however many of them there are.
#pragma once

#include <cstddef>
#include <vector>

#include "core/seam/sample_buffer.h"

namespace sft::core {

class VanillaPort {
 public:
  virtual ~VanillaPort() = default;

  /// Hands the sample over, which has all fields and may be read from then on for as long as the port keeps
  /// its handle. Returns at once: whoever sends the samples does not hold the publisher up, and the oldest
  /// ones that wait are left out if they are too many. Called by the publisher's thread.
  virtual void send(const SampleHandle& sample) noexcept = 0;

  // Called by the agent.

  /// What the publisher retained when it began to send by this port: to be sent before all that send()
  /// brings, which may have some of it, too. Once.
  virtual void begin_with(std::vector<SampleHandle> retained) = 0;

  /// How many readers there are at present. Any thread.
  virtual std::size_t readers() const noexcept = 0;
};

}  // namespace sft::core
