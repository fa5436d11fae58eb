#include "udp_transport/io/socket_io.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>
#include <utility>

#include "core/sync/spin.h"
#include "udp_transport/io/socket_sender.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;

constexpr int trains_per_call = 64;  // number of trains after which wake() and the deadline are checked again
constexpr int trains_in_a_row_max = 16;
}  // namespace

SocketReceiver::SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
    : socket_(std::move(socket)), wake_event_(std::move(wake_event)), train_(train_bytes_max) {}

bool SocketReceiver::receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept {
  const auto over = [&] { return receive_now(sink) || was_woken(); };
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
  for (int i = 0; ready[0].revents != 0 && i < trains_per_call && receive_now(sink); ++i) {
  }
  return (ready[0].revents & POLLNVAL) == 0;
}

/// Tries the unicast socket first. After many unicast trains in a row, tries the socket for groups first
/// once. Otherwise a unicast sender that never pauses would block that socket.
bool SocketReceiver::receive_now(DatagramSink& sink) noexcept {
  if (!socket_->in_groups.load(std::memory_order_relaxed)) return read_from(socket_->fd.get(), sink);
  if (trains_in_a_row_ == trains_in_a_row_max) {
    trains_in_a_row_ = 0;
    if (receive_from_groups(sink)) return true;
  }
  if (read_from(socket_->fd.get(), sink)) {
    ++trains_in_a_row_;
    return true;
  }
  trains_in_a_row_ = 0;
  return receive_from_groups(sink);
}

bool SocketReceiver::receive_from_groups(DatagramSink& sink) noexcept {
  const FileDescriptor& groups = socket_->groups.group_fd;
  return groups && read_from(groups.get(), sink);
}

bool SocketReceiver::read_from(int fd, DatagramSink& sink) noexcept {
  sockaddr_in6 from{};
  iovec whole{train_.data(), train_.size()};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &whole;
  message.msg_iovlen = 1;
  message.msg_control = control_;
  message.msg_controllen = sizeof control_;
  const ssize_t bytes = ::recvmsg(fd, &message, MSG_DONTWAIT);
  // Other errors are about an earlier datagram, and the call has cleared them.
  if (bytes < 0) return errno != EAGAIN;
  if ((message.msg_flags & MSG_TRUNC) != 0) return true;
  hand_over(std::span(train_).first(static_cast<std::size_t>(bytes)),
            std::span(control_).first(message.msg_controllen), from, sink);
  return true;
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

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket) {
  Result<FileDescriptor> wake_event = open_wake_event();
  if (!wake_event) return tl::unexpected<Error>(std::move(wake_event.error()));
  Result<std::unique_ptr<DatagramSender>> sender = open_socket_sender(socket);
  if (!sender) return tl::unexpected<Error>(std::move(sender.error()));
  DatagramIo io;
  io.description = socket->receives_trains ? "plain sockets with GRO and GSO" : "plain sockets with GSO";
  io.receiver = std::make_unique<SocketReceiver>(std::move(socket), std::move(*wake_event));
  io.sender = std::move(*sender);
  return io;
}

}  // namespace sft::udp
