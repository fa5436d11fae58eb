// A file descriptor to wait on in an event loop (epoll, asio), readable while it is raised.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::core {

/// Any thread, at any time. Whoever lowers it looks afterwards whether there is something to raise it for
/// again: what came in before that is not told twice.
class PollHandle {
 public:
  static Result<std::unique_ptr<PollHandle>> create();

  void raise() noexcept;
  void lower() noexcept;
  bool is_raised() const noexcept { return raised_.load(std::memory_order_seq_cst); }
  /// Until it is raised, or the time is over. Spurious returns are possible.
  void wait(std::chrono::steady_clock::time_point deadline) const noexcept;
  int descriptor() const { return event_.get(); }

 private:
  explicit PollHandle(FileDescriptor event) : event_(std::move(event)) {}

  const FileDescriptor event_;       ///< an eventfd
  std::atomic<bool> raised_{false};  ///< so that what is readable already costs no system call
};

}  // namespace sft::core
