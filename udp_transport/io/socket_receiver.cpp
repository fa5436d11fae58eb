#include "udp_transport/io/socket_receiver.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/sync/spin.h"
#include "udp_transport/io/wake_event.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;

constexpr int trains_per_call = 64;  // number of trains after which wake() and the deadline are checked again
}  // namespace

SocketReceiver::SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
    : socket_(socket), wake_event_(std::move(wake_event)), trains_(std::move(socket)) {}

bool SocketReceiver::receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept {
  const auto over = [&] { return trains_.read(sink) || was_woken(); };
  if (spin.count() > 0 && core::spin(std::min(deadline, Clock::now() + spin), over))
    deadline = {};  // so that the last poll below does not wait
  std::array<pollfd, 2> ready{{{.fd = socket_->readable(), .events = POLLIN, .revents = 0},
                               {.fd = wake_event_.get(), .events = POLLIN, .revents = 0}}};
  if (!poll_until(ready, deadline)) return true;
  if (ready[1].revents != 0) {
    woken_.store(false, std::memory_order_relaxed);
    eventfd_t ignored = 0;
    ::eventfd_read(wake_event_.get(), &ignored);
  }
  for (int i = 0; ready[0].revents != 0 && i < trains_per_call && trains_.read(sink); ++i) {
  }
  return (ready[0].revents & POLLNVAL) == 0;
}

void SocketReceiver::wake() noexcept {
  ::eventfd_write(wake_event_.get(), 1);
  woken_.store(true, std::memory_order_relaxed);
}

/// Returns true if the flag `woken_` was set, and clears it. wake() may set the flag after its event was
/// read. If the flag stayed set, it would end each later spin.
bool SocketReceiver::was_woken() noexcept {
  return woken_.load(std::memory_order_relaxed) && woken_.exchange(false, std::memory_order_relaxed);
}

}  // namespace sft::udp
