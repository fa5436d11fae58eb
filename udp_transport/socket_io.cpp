#include "udp_transport/socket_io.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <array>
#include <cerrno>
#include <vector>

#include "udp_transport/socket_sender.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t train_bytes_max = 65536;
constexpr int trains_per_call = 64;  // then wake() and the deadline are looked at again

class SocketReceiver final : public DatagramReceiver {
 public:
  SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
      : socket_(std::move(socket)), wake_event_(std::move(wake_event)), train_(train_bytes_max) {}

  bool receive(DatagramSink& sink, Clock::time_point deadline) noexcept override {
    const int group_fd = socket_->group_fd ? socket_->group_fd.get() : -1;
    std::array<pollfd, 3> ready{{{.fd = socket_->fd.get(), .events = POLLIN, .revents = 0},
                                 {.fd = wake_event_.get(), .events = POLLIN, .revents = 0},
                                 {.fd = group_fd, .events = POLLIN, .revents = 0}}};
    const bool limited = deadline != Clock::time_point::max();
    const timespec timeout = limited ? time_until(deadline) : timespec{};
    if (::ppoll(ready.data(), ready.size(), limited ? &timeout : nullptr, nullptr) < 0) return errno == EINTR;
    if (ready[1].revents != 0) {
      eventfd_t ignored = 0;
      ::eventfd_read(wake_event_.get(), &ignored);
    }
    if (ready[0].revents != 0) drain(socket_->fd.get(), sink);
    if (ready[2].revents != 0) drain(group_fd, sink);
    return (ready[0].revents & POLLNVAL) == 0;
  }

  void wake() noexcept override { ::eventfd_write(wake_event_.get(), 1); }
  void finish() noexcept override {}

 private:
  void drain(int fd, DatagramSink& sink) noexcept {
    for (int i = 0; i < trains_per_call; ++i) {
      sockaddr_in from{};
      iovec whole{train_.data(), train_.size()};
      msghdr message{};
      message.msg_name = &from;
      message.msg_namelen = sizeof from;
      message.msg_iov = &whole;
      message.msg_iovlen = 1;
      message.msg_control = control_;
      message.msg_controllen = sizeof control_;
      const ssize_t bytes = ::recvmsg(fd, &message, MSG_DONTWAIT);
      if (bytes < 0) return;  // nothing left, or an error that the call has cleared
      if ((message.msg_flags & MSG_TRUNC) != 0) continue;
      hand_over(std::span(train_).first(static_cast<std::size_t>(bytes)),
                std::span(control_).first(message.msg_controllen), from, sink);
    }
  }

  std::shared_ptr<const UdpSocket> socket_;
  FileDescriptor wake_event_;
  std::vector<std::byte> train_;
  alignas(cmsghdr) std::byte control_[train_control_bytes];
};

}  // namespace

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket) {
  FileDescriptor wake_event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake_event)
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  Result<std::unique_ptr<DatagramSender>> sender = open_socket_sender(socket);
  if (!sender) return tl::unexpected<Error>(std::move(sender.error()));
  DatagramIo io;
  io.description = socket->receives_trains ? "plain sockets with GRO and GSO" : "plain sockets with GSO";
  io.receiver = std::make_unique<SocketReceiver>(std::move(socket), std::move(wake_event));
  io.sender = std::move(*sender);
  return io;
}

}  // namespace sft::udp
