#include "udp_transport/io/socket_sender.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "core/sync/mutex.h"
#include "udp_transport/io/group_socket.h"

namespace sft::udp {

namespace {

using Clock = std::chrono::steady_clock;

class SocketConnection;

/// The state that a sender and its connections share.
struct Shared {
  std::shared_ptr<const UdpSocket> socket;
  std::atomic<std::size_t> own_sockets{0};
  /// Connections that wait for room in their send buffers; used by the thread that calls await().
  std::vector<SocketConnection*> waiting;
};

class SocketConnection final : public Connection {
 public:
  SocketConnection(const SocketAddress& to, std::shared_ptr<Shared> shared)
      : shared_(std::move(shared)), family_(SystemAddress(to).family()), to_(to) {
    if (shared_->own_sockets.fetch_add(1, std::memory_order_relaxed) < sending_sockets_max)
      own_ = open_sending_socket(shared_->socket->options, family_.load());
    if (!own_) shared_->own_sockets.fetch_sub(1, std::memory_order_relaxed);
    connect();
  }
  SocketConnection(const SocketAddress& group, const SocketAddress& own, std::shared_ptr<Shared> shared)
      : shared_(std::move(shared)), family_(SystemAddress(group).family()), to_(group) {
    own_ = open_sending_socket(shared_->socket->options, family_.load());
    shared_->own_sockets.fetch_add(own_ ? 1 : 0, std::memory_order_relaxed);
    if (own_) send_to_groups_by(own_.get(), own);
    connect();
  }
  ~SocketConnection() override {
    if (own_) shared_->own_sockets.fetch_sub(1, std::memory_order_relaxed);
  }

  /// Passes the address with the datagrams if the socket is not connected. The socket is also unconnected
  /// for a moment while another thread reconnects it.
  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    Sent sent{};
    if (connected_.load(std::memory_order_relaxed)) {
      sent = send_at_once(fd(), batches, nullptr);
      if (sent.outcome != SendOutcome::failed) return sent;
    }
    const SystemAddress to =
        own_ ? SystemAddress(address()) : SystemAddress::for_socket(address(), shared_->socket->family);
    Sent rest = send_at_once(fd(), batches.subspan(sent.batches), &to);
    rest.batches += sent.batches;
    rest.refused = rest.refused || sent.refused;
    return rest;
  }

  void carry_bulk() noexcept override {
    if (own_) give_way(own_.get());
  }

  void reconnect() noexcept override { connect(); }

  void redirect(const SocketAddress& to) noexcept override {
    {
      const core::Lock lock(mutex_);
      to_ = to;
    }
    connect();
  }

  void wait_for_room() noexcept override {
    full_ = true;
    shared_->waiting.push_back(this);
  }
  bool full() const noexcept override { return full_; }

  void has_room() noexcept { full_ = false; }
  int fd() const noexcept { return own_ ? own_.get() : shared_->socket->fd.get(); }

 private:
  SocketAddress address() noexcept {
    const core::Lock lock(mutex_);
    return to_;
  }

  /// Connects the socket to the present address. Repeats that if the address has changed meanwhile, since
  /// the socket may then be connected to the former address.
  void connect() noexcept {
    if (!own_) return;
    SocketAddress to;
    do {
      to = address();
      connect(SystemAddress(to));
    } while (to != address());
  }

  /// Disconnects first, since the kernel would keep the source address and the route that it chose before.
  void connect(const SystemAddress& to) noexcept {
    connected_.store(false, std::memory_order_relaxed);
    if (to.family() != family_.load(std::memory_order_relaxed)) change_family(to.family());
    const sockaddr nobody{.sa_family = AF_UNSPEC, .sa_data = {}};
    ::connect(own_.get(), &nobody, sizeof nobody);
    const bool connected = ::connect(own_.get(), to.get(), to.bytes()) == 0;
    if (connected && to.family() == AF_INET) fit_to_path(own_.get());
    connected_.store(connected, std::memory_order_relaxed);
  }

  /// Replaces the connection's socket by one of another family, with the same descriptor. Threads that are
  /// using the descriptor continue with the new socket.
  void change_family(int family) noexcept {
    const FileDescriptor other = open_sending_socket(shared_->socket->options, family);
    if (other && ::dup3(other.get(), own_.get(), O_CLOEXEC) >= 0)
      family_.store(family, std::memory_order_relaxed);
  }

  const std::shared_ptr<Shared> shared_;
  /// The connection's own socket; invalid: the connection sends through the receiving socket.
  FileDescriptor own_;
  std::atomic<int> family_;  ///< family of `own_`
  std::atomic<bool> connected_{false};
  bool full_ = false;  ///< used by the thread that calls await()
  core::Mutex mutex_;
  SocketAddress to_ SFT_GUARDED_BY(mutex_);
};

class SocketSender final : public DatagramSender {
 public:
  SocketSender(std::shared_ptr<const UdpSocket> socket, std::shared_ptr<const UdpSocket> answers,
               FileDescriptor wake_event)
      : shared_(std::make_shared<Shared>()),
        answers_(std::move(answers)),
        wake_event_(std::move(wake_event)) {
    shared_->socket = std::move(socket);
    shared_->waiting.reserve(waiting_foreseen);
    polled_.reserve(2 + waiting_foreseen);
  }

  std::uint16_t answer_port() const noexcept override { return answers_ == nullptr ? 0 : answers_->port; }
  Answer take_answer(std::span<std::byte> to) noexcept override {
    if (answers_ == nullptr) return {};
    for (;;) {  // an empty datagram is skipped, since more answers may follow it
      sockaddr_in6 from{};
      socklen_t from_bytes = sizeof from;
      const ssize_t bytes = ::recvfrom(answers_->fd.get(), to.data(), to.size(), MSG_DONTWAIT,
                                       reinterpret_cast<sockaddr*>(&from), &from_bytes);
      if (bytes < 0) return {};
      if (bytes > 0) return {static_cast<std::size_t>(bytes), to_address(from)};
    }
  }

  std::unique_ptr<Connection> connect(const SocketAddress& to) override {
    return std::make_unique<SocketConnection>(to, shared_);
  }

  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) override {
    return std::make_unique<SocketConnection>(group, own, shared_);
  }

  void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept override {
    const SystemAddress address = SystemAddress::for_socket(to, shared_->socket->family);
    // The cast is safe, because the datagram is only read.
    const iovec part{const_cast<std::byte*>(datagram.data()), datagram.size()};
    const OutgoingBatch batch{{&part, 1}, 0};
    send_at_once(shared_->socket->fd.get(), {&batch, 1}, &address);
  }

  void await(Clock::time_point deadline) noexcept override {
    std::vector<SocketConnection*>& waiting = shared_->waiting;
    const int answers = answers_ == nullptr ? -1 : answers_->fd.get();  // poll() ignores -1
    polled_.assign({{.fd = wake_event_.get(), .events = POLLIN, .revents = 0},
                    {.fd = answers, .events = POLLIN, .revents = 0}});
    const std::size_t others = polled_.size();
    for (const SocketConnection* connection : waiting)
      polled_.push_back({.fd = connection->fd(), .events = POLLOUT, .revents = 0});
    if (poll_until(polled_, deadline)) {
      for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (polled_[others + i].revents != 0) waiting[i]->has_room();
      }
      eventfd_t ignored = 0;
      if (polled_[0].revents != 0) ::eventfd_read(wake_event_.get(), &ignored);
    }
    waiting.clear();
    if ((polled_[0].revents & POLLNVAL) != 0) std::this_thread::sleep_for(pause_without_descriptors);
  }

  void wake() noexcept override { ::eventfd_write(wake_event_.get(), 1); }

 private:
  /// The pause if the program has closed all descriptors (closefrom(3)). Then there is no event to wait for.
  static constexpr std::chrono::milliseconds pause_without_descriptors{100};
  /// The number of connections that can be full at a time without an allocation.
  static constexpr std::size_t waiting_foreseen = 64;

  const std::shared_ptr<Shared> shared_;
  /// The socket for answers; null if answers come to the receiving socket.
  const std::shared_ptr<const UdpSocket> answers_;
  const FileDescriptor wake_event_;
  std::vector<pollfd> polled_;
};

constexpr std::size_t answers_buffer_bytes = 256 * 1024;

/// Opens a socket for answers, which the sending thread reads between sends. So no thread has to be woken
/// for answers. If a user has chosen the port, there is no such socket: answers come to the chosen port,
/// because firewalls and address translation are configured for that port.
std::shared_ptr<const UdpSocket> open_answers(const SocketOptions& options) {
  if (options.bind.port != 0) return nullptr;
  Result<std::shared_ptr<const UdpSocket>> socket =
      open_udp_socket({.bind = options.bind, .receive_buffer_bytes = answers_buffer_bytes});
  return socket ? std::move(*socket) : nullptr;
}

}  // namespace

Result<std::unique_ptr<DatagramSender>> open_socket_sender(std::shared_ptr<const UdpSocket> socket) {
  Result<FileDescriptor> wake_event = open_wake_event();
  if (!wake_event) return tl::unexpected<Error>(std::move(wake_event.error()));
  std::shared_ptr<const UdpSocket> answers = open_answers(socket->options);
  return std::make_unique<SocketSender>(std::move(socket), std::move(answers), std::move(*wake_event));
}

}  // namespace sft::udp
