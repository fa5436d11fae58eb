// Work that a publisher's thread hands over to the sending thread.
#pragma once

#include <memory>

namespace sft::udp {

class DeferredWork {
 public:
  virtual ~DeferredWork() = default;
  /// Does a part of the work that takes some milliseconds at most. Returns true if something is left. The
  /// function is then called again after other work has had its turn.
  virtual bool carry_out() noexcept = 0;

 private:
  friend class ScheduledWork;
  /// The work that was scheduled before this one, while both are scheduled.
  std::shared_ptr<DeferredWork> next_;
};

}  // namespace sft::udp
