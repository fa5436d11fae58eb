// The samples that a selection of a subscriber gets by shared memory. First come the samples that wait in a
// port whose memory was lost, then those of the present port. The mutex of SubscriberPorts protects the
// object. The destructor of a port may return memory to the system. So functions return former ports, and the
// caller destroys them after it has unlocked the mutex.
#pragma once

#include <cstdint>
#include <memory>

#include "core/seam/transport.h"

namespace sft::core {

class MemoryInlet {
 public:
  using Port = std::shared_ptr<BorrowingReader>;

  // The present port, and the port whose memory was lost. Null if there is no such port.
  const Port& port() const { return port_; }
  const Port& lost() const { return lost_; }
  /// Replaces the present port. Returns the former one.
  [[nodiscard]] Port replace(Port port);
  /// Called when the memory was lost. Samples that have arrived by the port can still be taken. Returns the
  /// port that was lost earlier, whose samples are dropped.
  [[nodiscard]] Port lose();
  /// Removes and returns the lost port if no sample waits in it, or if `also_if_some_wait` is true.
  [[nodiscard]] Port release(bool also_if_some_wait);

  /// Returns the next sample, or an empty handle if there is none.
  SampleHandle take();
  SampleHandle take_of(EndpointId writer);
  /// Returns true if a sample waits, even a sample that cannot be taken because max_held samples are held.
  bool some_wait() const;
  /// Returns the sum of the counts of both ports; see BorrowingReader.
  std::uint64_t held_too_many() const;

 private:
  Port port_, lost_;
};

}  // namespace sft::core
