// A file descriptor for waiting in an event loop (epoll, asio). It is readable while the handle is raised.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::core {

/// Any thread may call any function at any time. After lower(), the caller must check if there is a reason to
/// raise the handle again: an event that raised the handle before lower() does not raise it a second time.
class PollHandle {
 public:
  static Result<std::unique_ptr<PollHandle>> create();

  void raise() noexcept;
  void lower() noexcept;
  bool is_raised() const noexcept { return raised_.load(std::memory_order_seq_cst); }
  /// Waits until the handle is raised or the time is over. Spurious returns are possible.
  void wait(std::chrono::steady_clock::time_point deadline) const noexcept;
  int descriptor() const { return event_.get(); }

 private:
  explicit PollHandle(FileDescriptor event) : event_(std::move(event)) {}

  const FileDescriptor event_;       ///< an eventfd
  std::atomic<bool> raised_{false};  ///< saves system calls, because a raised handle need not be raised again
};

}  // namespace sft::core
