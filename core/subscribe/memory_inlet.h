// The samples that come to a selection of a subscriber by shared memory: those of its port there, and before
// them what waits in a port whose memory was lost. The mutex of the subscriber's ports guards it. A port may
// return memory to the system when it ends, so whoever gets one back lets go of it without a mutex.
#pragma once

#include <cstdint>
#include <memory>

#include "core/seam/transport.h"

namespace sft::core {

class MemoryInlet {
 public:
  using Port = std::shared_ptr<BorrowingReader>;

  /// Null: there is none.
  const Port& port() const { return port_; }
  const Port& lost() const { return lost_; }
  /// Returns the port before.
  [[nodiscard]] Port replace(Port port);
  /// The memory was lost: what has come by the port can still be taken. Returns the port that was lost
  /// before, whose time is over.
  [[nodiscard]] Port lose();
  /// Returns the lost port if nothing waits in it, or it is to go nevertheless.
  [[nodiscard]] Port release(bool also_if_some_wait);

  /// The next sample; null if there is none.
  SampleHandle take();
  SampleHandle take_of(EndpointId writer);
  /// True if a sample waits, also one that cannot be taken because as many are held as may be.
  bool some_wait() const;
  /// See BorrowingReader; of both ports.
  std::uint64_t held_too_many() const;

 private:
  Port port_, lost_;
};

}  // namespace sft::core
