// The contender TCP. It sends samples over connections, one for each reader, with the kernel's default
// settings.
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/raw_address.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t first_port = 45'000;

int tcp_socket() { return socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0); }

int connected_socket(const sockaddr_in& peer) {
  const int fd = tcp_socket();
  const auto connects = [&] {
    return connect(fd, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0;
  };
  if (!wait_until(connects)) std::abort();
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return fd;
}

void send_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) std::abort();
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

class RawTcpWriter : public Writer {
 public:
  explicit RawTcpWriter(const Topic& topic) : sample_(topic.bulk_bytes, std::byte{1}) {
    for (std::size_t i = 0; i < topic.readers; ++i)
      sockets_.push_back(connected_socket(reader_address(topic, i, first_port)));
  }
  ~RawTcpWriter() override {
    for (const int fd : sockets_) close(fd);
  }
  RawTcpWriter(const RawTcpWriter&) = delete;
  RawTcpWriter& operator=(const RawTcpWriter&) = delete;

  std::size_t readers() const override { return sockets_.size(); }
  void write(std::uint64_t number) override {
    std::memcpy(sample_.data(), &number, sizeof number);
    for (const int fd : sockets_) send_all(fd, sample_);
  }

 private:
  std::vector<int> sockets_;
  std::vector<std::byte> sample_;
};

/// Receives from the first writer that connects.
class RawTcpReader : public Reader {
 public:
  RawTcpReader(const Topic& topic, Arrived arrived)
      : arrived_(std::move(arrived)), sample_(topic.bulk_bytes), spinning_(topic.spinning) {
    const int on = 1;
    setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const sockaddr_in here = reader_address(topic, topic.reader, first_port, true);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) std::abort();
    if (listen(socket_, 1) != 0) std::abort();
    if (arrived_) thread_ = std::thread([this] { receive_all(); });
  }
  ~RawTcpReader() override {
    shutdown(socket_, SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
    close(socket_);
    if (connection_ >= 0) close(connection_);
  }
  RawTcpReader(const RawTcpReader&) = delete;
  RawTcpReader& operator=(const RawTcpReader&) = delete;

  std::size_t writers() const override { return 1; }
  void wait() override {
    if (receive()) std::memcpy(&come_, sample_.data(), sizeof come_);
  }
  std::uint64_t take() override { return std::exchange(come_, 0); }

 private:
  /// Receives a sample. Returns false if the writer has closed the connection.
  bool receive() {
    if (connection_ < 0) connection_ = accept(socket_, nullptr, nullptr);
    for (std::span<std::byte> missing = sample_; !missing.empty();) {
      const ssize_t bytes =
          recv(connection_, missing.data(), missing.size(), spinning_ ? MSG_DONTWAIT : MSG_WAITALL);
      if (bytes > 0) missing = missing.subspan(static_cast<std::size_t>(bytes));
      const bool nothing_yet = spinning_ && bytes < 0 && errno == EAGAIN;
      if (bytes <= 0 && !nothing_yet) return false;
    }
    return true;
  }
  /// Receives samples until the writer closes the connection.
  void receive_all() {
    while (receive()) {
      std::uint64_t number = 0;
      std::memcpy(&number, sample_.data(), sizeof number);
      arrived_(number);
    }
  }

  const int socket_ = tcp_socket();
  int connection_ = -1;
  const Arrived arrived_;
  std::vector<std::byte> sample_;
  const bool spinning_;
  std::uint64_t come_ = 0;  ///< the number of the sample to take; 0: there is no sample
  std::thread thread_;
};

class RawTcpPeer : public Peer {
 public:
  std::unique_ptr<Writer> writer(const Topic& topic) override {
    return std::make_unique<RawTcpWriter>(topic);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    return std::make_unique<RawTcpReader>(topic, std::move(arrived));
  }
};

}  // namespace

std::unique_ptr<Peer> raw_tcp_peer() { return std::make_unique<RawTcpPeer>(); }

}  // namespace sft::bench
