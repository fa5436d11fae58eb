// Sends samples over a TCP connection, one after the other, with the kernel's default settings.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/udp/contender.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'902;

int tcp_socket() { return socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0); }

sockaddr_in receiver(std::uint32_t address) {
  sockaddr_in receiver{};
  receiver.sin_family = AF_INET;
  receiver.sin_port = htons(port);
  receiver.sin_addr.s_addr = address;
  return receiver;
}

class RawTcpWriter : public Writer {
 public:
  RawTcpWriter(const Topic& topic, bool copies)
      : sample_(topic.bulk_bytes, std::byte{1}), kept_(copies ? topic.bulk_bytes : 0) {
    const sockaddr_in peer = receiver(TwoHosts::receiver_address());
    const auto connects = [&] {
      return connect(socket_, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0;
    };
    if (!wait_until(connects)) std::abort();
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  ~RawTcpWriter() override { close(socket_); }
  RawTcpWriter(const RawTcpWriter&) = delete;
  RawTcpWriter& operator=(const RawTcpWriter&) = delete;

  std::size_t readers() const override { return 1; }
  void write(std::uint64_t number) override {
    std::memcpy(sample_.data(), &number, sizeof number);
    if (!kept_.empty()) kept_ = sample_;
    const std::vector<std::byte>& from = kept_.empty() ? sample_ : kept_;
    for (std::size_t at = 0; at < from.size();) {
      const ssize_t sent = send(socket_, from.data() + at, from.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) std::abort();
      at += static_cast<std::size_t>(sent);
    }
  }

 private:
  const int socket_ = tcp_socket();
  std::vector<std::byte> sample_;
  std::vector<std::byte> kept_;  ///< the copy of a sample, if copies are made
};

/// Receives from the first writer that connects.
class RawTcpReader : public Reader {
 public:
  RawTcpReader(const Topic& topic, Arrived arrived)
      : arrived_(std::move(arrived)), sample_(topic.bulk_bytes) {
    const int on = 1;
    setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const sockaddr_in here = receiver(INADDR_ANY);
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) std::abort();
    if (listen(socket_, 1) != 0) std::abort();
    thread_ = std::thread([this] { receive(); });
  }
  ~RawTcpReader() override {
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }
  RawTcpReader(const RawTcpReader&) = delete;
  RawTcpReader& operator=(const RawTcpReader&) = delete;

  std::size_t writers() const override { return 1; }

 private:
  /// Receives until the other side closes the connection.
  void receive() {
    const int connection = accept(socket_, nullptr, nullptr);
    while (recv(connection, sample_.data(), sample_.size(), MSG_WAITALL) ==
           static_cast<ssize_t>(sample_.size())) {
      std::uint64_t number = 0;
      std::memcpy(&number, sample_.data(), sizeof number);
      arrived_(number);
    }
    close(connection);
  }

  const int socket_ = tcp_socket();
  const Arrived arrived_;
  std::vector<std::byte> sample_;
  std::thread thread_;
};

class RawTcpPeer : public Peer {
 public:
  explicit RawTcpPeer(bool copies) : copies_(copies) {}

  std::unique_ptr<Writer> writer(const Topic& topic) override {
    return std::make_unique<RawTcpWriter>(topic, copies_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    return std::make_unique<RawTcpReader>(topic, std::move(arrived));
  }

 private:
  const bool copies_;
};

}  // namespace

std::unique_ptr<Peer> raw_tcp_peer() { return std::make_unique<RawTcpPeer>(false); }
std::unique_ptr<Peer> raw_tcp_copying_peer() { return std::make_unique<RawTcpPeer>(true); }

}  // namespace sft::bench
