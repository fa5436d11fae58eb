// Work that a publisher's thread hands over to the sending thread.
#pragma once

#include <memory>

namespace sft::udp {

class DeferredWork {
 public:
  virtual ~DeferredWork() = default;
  /// Does a part of it that takes no more than some milliseconds. True if something is left, for which it is
  /// called again once others have had their turn.
  virtual bool carry_out() noexcept = 0;

 private:
  friend class ScheduledWork;
  std::shared_ptr<DeferredWork> next_;  ///< the work that was added before, while this one is scheduled
};

}  // namespace sft::udp
