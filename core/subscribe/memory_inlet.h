// The samples that come to a selection of a subscriber by shared memory: those of its port there, and before
// them what was left of ports whose memory was lost. The mutex of the subscriber's ports guards it.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>

#include "core/seam/transport.h"

namespace sft::core {

class MemoryInlet {
 public:
  /// Null: there is none at present.
  const std::shared_ptr<BorrowingReader>& port() const { return port_; }
  /// Returns the port before.
  std::shared_ptr<BorrowingReader> replace(std::shared_ptr<BorrowingReader> port);

  /// What ends with a port. It may return memory to the system, so let go of it without a mutex.
  struct Lost {
    std::shared_ptr<BorrowingReader> port;
    std::deque<SampleHandle> dropped;
  };
  /// The memory was lost, and so is the port. The last `depth` samples that came by it and by the lost ones
  /// before are kept until they are taken.
  Lost lose(std::size_t depth);

  /// The next sample; null if there is none.
  SampleHandle take();
  SampleHandle take_of(EndpointId writer);
  /// True if a sample waits, also one that cannot be taken because as many are held as may be.
  bool some_wait() const { return !kept_.empty() || (port_ != nullptr && port_->some_wait()); }

 private:
  std::shared_ptr<BorrowingReader> port_;
  std::deque<SampleHandle> kept_;  ///< of lost ports, the oldest first
};

}  // namespace sft::core
