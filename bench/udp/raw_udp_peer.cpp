// The least time that a transfer by UDP takes. For large samples, each system call hands over a train of
// datagrams, which the kernel cuts (GSO) and puts together again (GRO), directly from and into the sample's
// memory. The sender is at most one sample ahead of the last acknowledgement, so that no sample is lost to a
// full buffer and nobody sleeps between samples. For small samples, each side makes one system call per
// datagram, and neither side waits.
#include <arpa/inet.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/udp/contender.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'901;
constexpr int segment_bytes = 1472;  // an MTU of 1500 without the headers of IPv4 and UDP
constexpr std::size_t train_bytes = 44 * segment_bytes;
constexpr std::size_t small_datagram_bytes = 112;  // as with SFT's headers
constexpr std::size_t received_bytes_max = 65'536;
constexpr int buffer_bytes = 16 << 20;
constexpr std::uint64_t again = 0;  // instead of a number: the sample begins again

int udp_socket(std::uint16_t local_port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const timeval patience{0, 200'000};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(local_port);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) std::abort();
  return fd;
}

void connect_to_receiver(int fd) {
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(port);
  peer.sin_addr.s_addr = TwoHosts::receiver_address();
  if (connect(fd, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) != 0) std::abort();
}

/// Without an acknowledgement, the writer announces that it begins again, and sends the sample before.
class RawUdpWriter : public Writer {
 public:
  RawUdpWriter(const Topic& topic, bool copies)
      : message_(topic.bulk_bytes, std::byte{1}), kept_(copies ? 2 : 0, message_) {
    setsockopt(socket_, SOL_UDP, UDP_SEGMENT, &segment_bytes, sizeof segment_bytes);
    connect_to_receiver(socket_);
  }
  ~RawUdpWriter() override { close(socket_); }
  RawUdpWriter(const RawUdpWriter&) = delete;
  RawUdpWriter& operator=(const RawUdpWriter&) = delete;

  std::size_t readers() const override { return 1; }
  void write(std::uint64_t number) override {
    std::memcpy(message_.data(), &number, sizeof number);
    if (!kept_.empty()) kept(number) = message_;
    send_sample(number);
    while (!acknowledged(number - 1)) {
      send(socket_, &again, sizeof again, 0);
      send_sample(number - 1);
      send_sample(number);
    }
  }

 private:
  std::vector<std::byte>& kept(std::uint64_t number) { return kept_[number % kept_.size()]; }
  void send_sample(std::uint64_t number) {
    std::vector<std::byte>& sample = kept_.empty() ? message_ : kept(number);
    std::memcpy(sample.data(), &number, sizeof number);
    for (std::size_t at = 0; at < sample.size(); at += train_bytes)
      send(socket_, sample.data() + at, std::min(train_bytes, sample.size() - at), 0);
  }
  bool acknowledged(std::uint64_t number) {
    while (acknowledged_ < number) {
      if (recv(socket_, &acknowledged_, sizeof acknowledged_, 0) <= 0) return false;
    }
    return true;
  }

  const int socket_ = udp_socket(0);
  std::vector<std::byte> message_;
  std::vector<std::vector<std::byte>> kept_;  ///< copies of the last two samples, if copies are made
  std::uint64_t acknowledged_ = 0;
};

class RawUdpReader : public Reader {
 public:
  RawUdpReader(const Topic& topic, Arrived arrived)
      : arrived_(std::move(arrived)), sample_(topic.bulk_bytes + received_bytes_max) {
    const int on = 1;
    setsockopt(socket_, SOL_UDP, UDP_GRO, &on, sizeof on);
    thread_ = std::thread([this, bytes = topic.bulk_bytes] { receive(bytes); });
  }
  ~RawUdpReader() override {
    over_ = true;
    thread_.join();
    close(socket_);
  }
  RawUdpReader(const RawUdpReader&) = delete;
  RawUdpReader& operator=(const RawUdpReader&) = delete;

  std::size_t writers() const override { return 1; }

 private:
  void receive(std::size_t sample_bytes) {
    std::size_t come = 0;
    while (!over_) {
      sockaddr_in peer{};
      socklen_t length = sizeof peer;
      const ssize_t bytes = recvfrom(socket_, sample_.data() + come, received_bytes_max, 0,
                                     reinterpret_cast<sockaddr*>(&peer), &length);
      if (bytes <= 0) continue;
      come = bytes == sizeof again ? 0 : come + static_cast<std::size_t>(bytes);
      if (come < sample_bytes) continue;
      come = 0;
      std::uint64_t number = 0;
      std::memcpy(&number, sample_.data(), sizeof number);
      sendto(socket_, &number, sizeof number, 0, reinterpret_cast<const sockaddr*>(&peer), length);
      arrived_(number);
    }
  }

  const int socket_ = udp_socket(port);
  const Arrived arrived_;
  std::vector<std::byte> sample_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

class RawDatagramWriter : public Writer {
 public:
  RawDatagramWriter() { connect_to_receiver(socket_); }
  ~RawDatagramWriter() override { close(socket_); }
  RawDatagramWriter(const RawDatagramWriter&) = delete;
  RawDatagramWriter& operator=(const RawDatagramWriter&) = delete;

  std::size_t readers() const override { return 1; }
  void write(std::uint64_t number) override {
    std::memcpy(datagram_.data(), &number, sizeof number);
    send(socket_, datagram_.data(), datagram_.size(), 0);
  }

 private:
  const int socket_ = udp_socket(0);
  std::array<std::byte, small_datagram_bytes> datagram_{};
};

class RawDatagramReader : public Reader {
 public:
  explicit RawDatagramReader(Arrived arrived) : arrived_(std::move(arrived)) {}
  ~RawDatagramReader() override {
    over_ = true;
    thread_.join();
    close(socket_);
  }
  RawDatagramReader(const RawDatagramReader&) = delete;
  RawDatagramReader& operator=(const RawDatagramReader&) = delete;

  std::size_t writers() const override { return 1; }

 private:
  void receive() {
    while (!over_) {
      std::array<std::byte, small_datagram_bytes> datagram;
      if (recv(socket_, datagram.data(), datagram.size(), 0) <= 0) continue;
      std::uint64_t number = 0;
      std::memcpy(&number, datagram.data(), sizeof number);
      arrived_(number);
    }
  }

  const int socket_ = udp_socket(port);
  const Arrived arrived_;
  std::atomic<bool> over_{false};
  std::thread thread_{[this] { receive(); }};
};

class RawUdpPeer : public Peer {
 public:
  explicit RawUdpPeer(bool copies) : copies_(copies) {}
  std::unique_ptr<Writer> writer(const Topic& topic) override {
    if (topic.bulk_bytes == 0) return std::make_unique<RawDatagramWriter>();
    return std::make_unique<RawUdpWriter>(topic, copies_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    if (topic.bulk_bytes == 0) return std::make_unique<RawDatagramReader>(std::move(arrived));
    return std::make_unique<RawUdpReader>(topic, std::move(arrived));
  }

 private:
  const bool copies_;
};

}  // namespace

std::unique_ptr<Peer> raw_udp_peer() { return std::make_unique<RawUdpPeer>(false); }
std::unique_ptr<Peer> raw_udp_copying_peer() { return std::make_unique<RawUdpPeer>(true); }

}  // namespace sft::bench
