#include "udp_transport/socket_sender.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "udp_transport/group_socket.h"
#include "udp_transport/interfaces.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

class SocketConnection;

/// What a sender and its connections share.
struct Shared {
  std::shared_ptr<const UdpSocket> socket;
  std::atomic<std::size_t> own_sockets{0};
  std::vector<SocketConnection*> waiting;  ///< for room; of the thread that calls await()
};

class SocketConnection final : public Connection {
 public:
  SocketConnection(const SocketAddress& to, std::shared_ptr<Shared> shared)
      : to_(to_sockaddr(to)), shared_(std::move(shared)) {
    if (shared_->own_sockets.fetch_add(1, std::memory_order_relaxed) < sending_sockets_max)
      own_ = open_sending_socket(shared_->socket->options);
    if (!own_) shared_->own_sockets.fetch_sub(1, std::memory_order_relaxed);
    reconnect();
  }
  SocketConnection(const SocketAddress& group, const SocketAddress& own, std::shared_ptr<Shared> shared)
      : to_(to_sockaddr(group)), shared_(std::move(shared)) {
    own_ = open_sending_socket(shared_->socket->options);
    shared_->own_sockets.fetch_add(own_ ? 1 : 0, std::memory_order_relaxed);
    if (own_) send_to_groups_by(own_.get(), own);
    reconnect();
  }
  ~SocketConnection() override {
    if (own_) shared_->own_sockets.fetch_sub(1, std::memory_order_relaxed);
  }

  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    return send_at_once(fd(), batches, connected_.load(std::memory_order_relaxed) ? nullptr : &to_);
  }

  /// Undone first: the kernel would keep the source address and the route that it chose before.
  void reconnect() noexcept override {
    if (!own_) return;
    connected_.store(false, std::memory_order_relaxed);
    const sockaddr nobody{.sa_family = AF_UNSPEC, .sa_data = {}};
    ::connect(own_.get(), &nobody, sizeof nobody);
    const bool connected = ::connect(own_.get(), reinterpret_cast<const sockaddr*>(&to_), sizeof to_) == 0;
    connected_.store(connected, std::memory_order_relaxed);
  }

  void wait_for_room() noexcept override {
    full_ = true;
    shared_->waiting.push_back(this);
  }
  bool full() const noexcept override { return full_; }

  void has_room() noexcept { full_ = false; }
  int fd() const noexcept { return own_ ? own_.get() : shared_->socket->fd.get(); }

 private:
  const sockaddr_in to_;
  const std::shared_ptr<Shared> shared_;
  FileDescriptor own_;  ///< invalid: the socket that receives sends for this one too
  std::atomic<bool> connected_{false};
  bool full_ = false;  ///< of the thread that calls await()
};

class SocketSender final : public DatagramSender {
 public:
  SocketSender(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event)
      : shared_(std::make_shared<Shared>()), wake_event_(std::move(wake_event)) {
    shared_->socket = std::move(socket);
  }

  std::unique_ptr<Connection> connect(const SocketAddress& to) override {
    return std::make_unique<SocketConnection>(to, shared_);
  }

  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) override {
    return std::make_unique<SocketConnection>(group, own, shared_);
  }

  void await(Clock::time_point deadline) noexcept override {
    std::vector<SocketConnection*>& waiting = shared_->waiting;
    polled_.assign(1, {.fd = wake_event_.get(), .events = POLLIN, .revents = 0});
    for (const SocketConnection* connection : waiting)
      polled_.push_back({.fd = connection->fd(), .events = POLLOUT, .revents = 0});
    const bool limited = deadline != Clock::time_point::max();
    const timespec timeout = limited ? time_until(deadline) : timespec{};
    if (::ppoll(polled_.data(), polled_.size(), limited ? &timeout : nullptr, nullptr) > 0) {
      for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (polled_[i + 1].revents != 0) waiting[i]->has_room();
      }
      eventfd_t ignored = 0;
      if (polled_[0].revents != 0) ::eventfd_read(wake_event_.get(), &ignored);
    }
    waiting.clear();
  }

  void wake() noexcept override { ::eventfd_write(wake_event_.get(), 1); }

 private:
  const std::shared_ptr<Shared> shared_;
  const FileDescriptor wake_event_;
  std::vector<pollfd> polled_;
};

}  // namespace

Result<std::unique_ptr<DatagramSender>> open_socket_sender(std::shared_ptr<const UdpSocket> socket) {
  FileDescriptor wake_event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!wake_event)
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  return std::make_unique<SocketSender>(std::move(socket), std::move(wake_event));
}

}  // namespace sft::udp
