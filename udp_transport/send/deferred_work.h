// Work that a publisher's thread passes to the sending thread.
#pragma once

#include <memory>

namespace sft::udp {

class DeferredWork {
 public:
  virtual ~DeferredWork() = default;
  /// Does a part of the work, for a few milliseconds at most. Returns true if a part is left. Then the
  /// function is called again after other work has had its turn.
  virtual bool carry_out() noexcept = 0;

 private:
  friend class ScheduledWork;
  /// The work that was scheduled before this work, while both are scheduled.
  std::shared_ptr<DeferredWork> next_;
};

}  // namespace sft::udp
