#include "core/platform/poll_handle.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace sft::core {

Result<std::unique_ptr<PollHandle>> PollHandle::create() {
  FileDescriptor event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!event) return fail(Errc::system, std::string("eventfd: ") + std::strerror(errno));
  return std::unique_ptr<PollHandle>(new PollHandle(std::move(event)));
}

void PollHandle::raise() noexcept {
  // The exchange is made even if the handle is raised already, so that the thread that lowers the handle sees
  // the data of this thread.
  if (!raised_.exchange(true, std::memory_order_seq_cst)) ::eventfd_write(event_.get(), 1);
}

/// The order of the two steps matters. In the reverse order, the event of a raise() between the steps would
/// be consumed, although the handle would still count as raised.
void PollHandle::lower() noexcept {
  std::uint64_t ignored = 0;
  ::eventfd_read(event_.get(), &ignored);
  raised_.exchange(false, std::memory_order_seq_cst);
}

void PollHandle::wait(std::chrono::steady_clock::time_point deadline) const noexcept {
  using Clock = std::chrono::steady_clock;
  pollfd waits{.fd = event_.get(), .events = POLLIN, .revents = 0};
  if (deadline == Clock::time_point::max()) {
    ::ppoll(&waits, 1, nullptr, nullptr);
    return;
  }
  const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
  const auto s = std::chrono::floor<std::chrono::seconds>(left);
  const timespec timeout{.tv_sec = s.count(), .tv_nsec = std::chrono::nanoseconds(left - s).count()};
  ::ppoll(&waits, 1, &timeout, nullptr);
}

}  // namespace sft::core
