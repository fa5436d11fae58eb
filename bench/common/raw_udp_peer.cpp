// The contender UDP, which takes the least possible time for a transfer. For large samples, each system
// call hands over a train of datagrams. The kernel cuts the train (GSO) and puts it together again (GRO),
// directly from and into the sample's memory. The sender is ahead of the last acknowledgement by at most
// one large sample, or by some small samples. So no sample is lost to a full buffer, and neither side
// sleeps between samples. For samples that are not bulk, each side makes one system call per datagram, and
// neither side waits.
#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <span>
#include <thread>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/raw_address.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t first_port = 44'000;
constexpr int segment_bytes = 1472;  // an MTU of 1500 without the headers of IPv4 and UDP
constexpr std::size_t train_bytes = 44 * segment_bytes;
constexpr std::size_t small_datagram_bytes = 112;  // the length of SFT's datagram with a small sample
constexpr std::size_t received_bytes_max = 65'536;
constexpr int buffer_bytes = 16 << 20;
// Sent in place of a sample's number before all unacknowledged samples are sent once more.
constexpr std::uint64_t again = 0;

int udp_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const timeval timeout{0, 200'000};
  setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  return fd;
}

int reader_socket(const Topic& topic) {
  const int fd = udp_socket();
  const sockaddr_in here = reader_address(topic, topic.reader, first_port, true);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) std::abort();
  return fd;
}

int writer_socket(const Topic& topic, std::size_t reader) {
  const int fd = udp_socket();
  const sockaddr_in peer = reader_address(topic, reader, first_port);
  if (connect(fd, reinterpret_cast<const sockaddr*>(&peer), sizeof peer) != 0) std::abort();
  return fd;
}

/// Returns the number of samples by which the writer may be ahead of the last acknowledgement.
std::uint64_t samples_ahead(std::size_t sample_bytes) {
  constexpr std::size_t bytes_ahead = 256 << 10, samples_max = 32;
  return std::clamp<std::uint64_t>(bytes_ahead / sample_bytes, 1, samples_max);
}

/// A writer's socket for one reader. If an acknowledgement is missing, the writer announces a repetition,
/// and sends all samples that are not acknowledged.
class RawUdpLink {
 public:
  RawUdpLink(const Topic& topic, std::size_t reader) : socket_(writer_socket(topic, reader)) {
    setsockopt(socket_, SOL_UDP, UDP_SEGMENT, &segment_bytes, sizeof segment_bytes);
  }
  ~RawUdpLink() { close(socket_); }
  RawUdpLink(const RawUdpLink&) = delete;
  RawUdpLink& operator=(const RawUdpLink&) = delete;

  void send_sample(std::span<const std::byte> sample) const {
    for (; !sample.empty(); sample = sample.subspan(std::min(train_bytes, sample.size())))
      send(socket_, sample.data(), std::min(train_bytes, sample.size()), 0);
  }
  void begin_again() const { send(socket_, &again, sizeof again, 0); }
  /// Waits for the acknowledgement of a sample. Returns false if the acknowledgement does not arrive in
  /// time.
  bool acknowledged(std::uint64_t number) {
    while (acknowledged_ < number) {
      if (recv(socket_, &acknowledged_, sizeof acknowledged_, 0) <= 0) return false;
    }
    return true;
  }

 private:
  const int socket_;
  std::uint64_t acknowledged_ = 0;
};

class RawUdpWriter : public Writer {
 public:
  RawUdpWriter(const Topic& topic, bool copies)
      : ahead_(samples_ahead(topic.bulk_bytes)),
        message_(topic.bulk_bytes, std::byte{1}),
        kept_(copies ? ahead_ + 1 : 0, message_) {
    for (std::size_t i = 0; i < topic.readers; ++i) links_.push_back(std::make_unique<RawUdpLink>(topic, i));
  }

  std::size_t readers() const override { return links_.size(); }
  void write(std::uint64_t number) override {
    std::memcpy(message_.data(), &number, sizeof number);
    if (!kept_.empty()) kept(number) = message_;
    for (const auto& link : links_) link->send_sample(sample(number));
    const std::uint64_t oldest = number - std::min(number, ahead_);
    for (const auto& link : links_) {
      while (!link->acknowledged(oldest)) {
        link->begin_again();
        for (std::uint64_t i = std::max<std::uint64_t>(oldest, 1); i <= number; ++i)
          link->send_sample(sample(i));
      }
    }
  }

 private:
  std::vector<std::byte>& kept(std::uint64_t number) { return kept_[number % kept_.size()]; }
  std::span<const std::byte> sample(std::uint64_t number) {
    std::vector<std::byte>& sample = kept_.empty() ? message_ : kept(number);
    std::memcpy(sample.data(), &number, sizeof number);
    return sample;
  }

  const std::uint64_t ahead_;
  std::vector<std::unique_ptr<RawUdpLink>> links_;
  std::vector<std::byte> message_;
  std::vector<std::vector<std::byte>> kept_;  ///< copies of the last samples, if the contender makes copies
};

class RawUdpReader : public Reader {
 public:
  RawUdpReader(const Topic& topic, const Arrived& arrived)
      : socket_(reader_socket(topic)),
        bytes_(topic.bulk_bytes),
        spinning_(topic.spinning),
        arrived_(arrived ? arrived : [this](std::uint64_t number) { come_.push_back(number); }),
        memory_(topic.bulk_bytes + received_bytes_max) {
    const int on = 1;
    setsockopt(socket_, SOL_UDP, UDP_GRO, &on, sizeof on);
    if (!arrived) return;
    thread_ = std::thread([this] {
      while (!over_) receive();
    });
  }
  ~RawUdpReader() override {
    over_ = true;
    if (thread_.joinable()) thread_.join();
    close(socket_);
  }
  RawUdpReader(const RawUdpReader&) = delete;
  RawUdpReader& operator=(const RawUdpReader&) = delete;

  std::size_t writers() const override { return 1; }
  void wait() override {
    while (come_.empty()) receive();
  }
  std::uint64_t take() override {
    if (come_.empty()) return 0;
    const std::uint64_t number = come_.front();
    come_.pop_front();
    return number;
  }

 private:
  /// Receives a train of datagrams. The train may contain the end of a sample, or several samples.
  void receive() {
    sockaddr_in peer{};
    socklen_t length = sizeof peer;
    const ssize_t bytes = recvfrom(socket_, memory_.data() + filled_, received_bytes_max,
                                   spinning_ ? MSG_DONTWAIT : 0, reinterpret_cast<sockaddr*>(&peer), &length);
    if (bytes <= 0) return;
    filled_ = bytes == sizeof again ? 0 : filled_ + static_cast<std::size_t>(bytes);
    std::size_t at = 0;
    for (; filled_ - at >= bytes_; at += bytes_) {
      std::uint64_t number = 0;
      std::memcpy(&number, memory_.data() + at, sizeof number);
      arrived_(number);
      sendto(socket_, &number, sizeof number, 0, reinterpret_cast<const sockaddr*>(&peer), length);
    }
    if (at > 0) std::memmove(memory_.data(), memory_.data() + at, filled_ - at);
    filled_ -= at;
  }

  const int socket_;
  const std::size_t bytes_;
  const bool spinning_;
  std::deque<std::uint64_t> come_;  ///< numbers of the samples to take, if the reader has no callback
  const Arrived arrived_;
  std::vector<std::byte> memory_;
  std::size_t filled_ = 0;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

class RawDatagramWriter : public Writer {
 public:
  explicit RawDatagramWriter(const Topic& topic) : socket_(writer_socket(topic, 0)) {}
  ~RawDatagramWriter() override { close(socket_); }
  RawDatagramWriter(const RawDatagramWriter&) = delete;
  RawDatagramWriter& operator=(const RawDatagramWriter&) = delete;

  std::size_t readers() const override { return 1; }
  void write(std::uint64_t number) override {
    std::memcpy(datagram_.data(), &number, sizeof number);
    send(socket_, datagram_.data(), datagram_.size(), 0);
  }

 private:
  const int socket_;
  std::array<std::byte, small_datagram_bytes> datagram_{};
};

class RawDatagramReader : public Reader {
 public:
  RawDatagramReader(const Topic& topic, Arrived arrived)
      : socket_(reader_socket(topic)), arrived_(std::move(arrived)) {}
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

  const int socket_;
  const Arrived arrived_;
  std::atomic<bool> over_{false};
  std::thread thread_{[this] { receive(); }};
};

class RawUdpPeer : public Peer {
 public:
  explicit RawUdpPeer(bool copies) : copies_(copies) {}
  std::unique_ptr<Writer> writer(const Topic& topic) override {
    if (topic.bulk_bytes == 0) return std::make_unique<RawDatagramWriter>(topic);
    return std::make_unique<RawUdpWriter>(topic, copies_);
  }
  std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived) override {
    if (topic.bulk_bytes == 0) return std::make_unique<RawDatagramReader>(topic, std::move(arrived));
    return std::make_unique<RawUdpReader>(topic, arrived);
  }

 private:
  const bool copies_;
};

}  // namespace

std::unique_ptr<Peer> raw_udp_peer() { return std::make_unique<RawUdpPeer>(false); }
std::unique_ptr<Peer> raw_udp_copying_peer() { return std::make_unique<RawUdpPeer>(true); }

}  // namespace sft::bench
