// A handle with a file descriptor for waiting in an event loop (epoll, asio). The descriptor is readable
// while the handle is raised.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::core {

/// Any thread may call any function at any time. An event raises the handle only once. So after lower(),
/// the caller must check whether an event still has to be handled, and raise the handle again in this case.
class PollHandle {
 public:
  static Result<std::unique_ptr<PollHandle>> create();

  void raise() noexcept;
  void lower() noexcept;
  bool is_raised() const noexcept { return raised_.load(std::memory_order_seq_cst); }
  /// Waits until the handle is raised or the deadline has passed. Spurious returns are possible.
  void wait(std::chrono::steady_clock::time_point deadline) const noexcept;
  int descriptor() const { return event_.get(); }

 private:
  explicit PollHandle(FileDescriptor event) : event_(std::move(event)) {}

  const FileDescriptor event_;       ///< an eventfd
  std::atomic<bool> raised_{false};  ///< saves system calls, because a raised handle need not be raised again
};

}  // namespace sft::core
