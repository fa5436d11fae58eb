#include "udp_transport/socket_io.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <vector>

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t train_bytes_max = 65536;
constexpr int trains_per_call = 64;  // then wake() and the deadline are looked at again
constexpr timeval send_patience{.tv_sec = 0, .tv_usec = 100'000};  // then stop() is looked at

timespec until(Clock::time_point deadline) {
  using namespace std::chrono;
  const auto left = std::max(duration_cast<nanoseconds>(deadline - Clock::now()), nanoseconds{0});
  return {.tv_sec = static_cast<time_t>(left.count() / 1'000'000'000),
          .tv_nsec = static_cast<long>(left.count() % 1'000'000'000)};
}

class SocketReceiver final : public DatagramReceiver {
 public:
  SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
      : socket_(std::move(socket)), wake_event_(std::move(wake_event)), train_(train_bytes_max) {}

  bool receive(DatagramSink& sink, Clock::time_point deadline) noexcept override {
    std::array<pollfd, 2> ready{{{.fd = socket_->fd.get(), .events = POLLIN, .revents = 0},
                                 {.fd = wake_event_.get(), .events = POLLIN, .revents = 0}}};
    const bool limited = deadline != Clock::time_point::max();
    const timespec timeout = limited ? until(deadline) : timespec{};
    if (::ppoll(ready.data(), ready.size(), limited ? &timeout : nullptr, nullptr) < 0) return errno == EINTR;
    if (ready[1].revents != 0) {
      eventfd_t ignored = 0;
      ::eventfd_read(wake_event_.get(), &ignored);
    }
    if (ready[0].revents != 0) drain(sink);
    return (ready[0].revents & POLLNVAL) == 0;
  }

  void wake() noexcept override { ::eventfd_write(wake_event_.get(), 1); }
  void finish() noexcept override {}

 private:
  void drain(DatagramSink& sink) noexcept {
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
      const ssize_t bytes = ::recvmsg(socket_->fd.get(), &message, MSG_DONTWAIT);
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

class SocketSender final : public DatagramSender {
 public:
  explicit SocketSender(std::shared_ptr<const UdpSocket> socket) : socket_(std::move(socket)) {}

  SendOutcome try_send(const OutgoingBatch& batch) noexcept override { return send_at_once(*socket_, batch); }

  SendOutcome send(std::span<const OutgoingBatch> batches) noexcept override {
    for (const OutgoingBatch& batch : batches) {
      if (const SendOutcome outcome = send(batch); outcome != SendOutcome::sent) return outcome;
    }
    return SendOutcome::sent;
  }

  void stop() noexcept override { stopped_.store(true, std::memory_order_relaxed); }
  void finish() noexcept override {}

 private:
  SendOutcome send(const OutgoingBatch& batch) noexcept {
    OutgoingMessage message;
    message.set(batch);
    while (!stopped_.load(std::memory_order_relaxed)) {
      if (::sendmsg(socket_->fd.get(), &message.header(), 0) >= 0) return SendOutcome::sent;
      if (errno != EAGAIN && errno != EINTR) return outcome_of(errno);
    }
    return SendOutcome::failed;
  }

  std::shared_ptr<const UdpSocket> socket_;
  std::atomic<bool> stopped_{false};
};

}  // namespace

SendOutcome send_at_once(const UdpSocket& socket, const OutgoingBatch& batch) noexcept {
  OutgoingMessage message;
  message.set(batch);
  ssize_t sent = 0;
  do {
    sent = ::sendmsg(socket.fd.get(), &message.header(), MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  return sent < 0 ? outcome_of(errno) : SendOutcome::sent;
}

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket) {
  FileDescriptor wake_event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake_event.valid())
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  ::setsockopt(socket->fd.get(), SOL_SOCKET, SO_SNDTIMEO, &send_patience, sizeof send_patience);
  const std::string trains = socket->receives_trains ? "GRO and GSO" : "GSO";
  DatagramIo io;
  io.receiver = std::make_unique<SocketReceiver>(socket, std::move(wake_event));
  io.sender = std::make_unique<SocketSender>(std::move(socket));
  io.description = "plain sockets with " + trains;
  return io;
}

}  // namespace sft::udp
