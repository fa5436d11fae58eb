// A publisher and a subscriber of images, which use the ports of a transport directly.
#pragma once

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/seam/gate.h"
#include "core/seam/transport.h"
#include "tests/support/eventually.h"
#include "tests/unit/udp/messages.h"

namespace sft::udp::test {

using sft::test::hang_timeout;

inline core::UdpAddress loopback_address(const core::Network& transport) {
  core::UdpAddress address = transport.addresses().at(0);
  address.ip = address.ip.is_ipv4() ? core::loopback_ipv4 : core::loopback_ipv6;
  return address;
}

/// Returns false if the kernel has no IPv6 or IPv6 is switched off, so that there is no IPv6 loopback.
inline bool has_ipv6_loopback() {
  const int fd = ::socket(AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 loopback{};
  loopback.sin6_family = AF_INET6;
  loopback.sin6_addr = in6addr_loopback;
  const bool bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&loopback), sizeof loopback) == 0;
  if (fd >= 0) ::close(fd);
  return bound;
}

using sft::test::eventually;

inline std::shared_ptr<core::BufferPool> make_pool() {
  return core::BufferPool::make(std::size_t{256} << 20);
}

class Subscriber final : private core::ArrivalListener {
 public:
  Subscriber(core::Network& transport, const std::vector<std::string>& masks, std::uint32_t depth = 1000,
             core::EndpointId id = 1) {
    port_ =
        transport
            .open_reader(
                {.id = id, .type = &type_support<Image>(), .depth = depth, .listener = this, .doorbell = {}})
            .value();
    std::vector<core::Accepted> accepted;
    for (const std::string& mask : masks) accepted.push_back({.wanted = {selection_of<Image>(mask)}});
    port_->accept(accepted);
  }

  void listen_to(core::EndpointId writer, std::size_t max_sample_bytes = 0) {
    listen({.writer = writer, .max_sample_bytes = max_sample_bytes});
  }
  void listen_reliably_to(core::EndpointId writer) { listen({.writer = writer, .reliable = true}); }
  void listen_late_to(core::EndpointId writer, bool reliable = false) {
    listen({.writer = writer, .history_first = true, .reliable = reliable});
  }

  core::NetworkReader& port() { return *port_; }

  /// Waits until there are `count` samples, and returns all samples so far. Returns fewer after `at_most`.
  std::vector<core::SampleHandle> await(std::size_t count, std::chrono::seconds at_most = hang_timeout) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, at_most, [&] { return taken_.size() >= count; });
    return taken_;
  }
  /// Waits for `count` samples since the last call, and returns them. Returns fewer after a time-out.
  std::vector<core::SampleHandle> await_new(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, hang_timeout, [&] { return taken_.size() >= count; });
    return std::exchange(taken_, {});
  }
  std::vector<std::uint64_t> await_sequences(std::size_t count) {
    std::vector<std::uint64_t> sequences;
    for (const core::SampleHandle& sample : await(count)) sequences.push_back(sample->header().sequence);
    return sequences;
  }

 private:
  void listen(const core::Source& source) {
    const Result<void> connected = port_->connect(source);
    EXPECT_TRUE(connected) << connected.error().message;
  }
  void arrived() noexcept override {
    {
      const std::scoped_lock lock(mutex_);
      while (core::SampleHandle sample = port_->take()) taken_.push_back(std::move(sample));
    }
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<core::SampleHandle> taken_;
  std::unique_ptr<core::NetworkReader> port_;  // destroyed first; after that no thread calls arrived()
};

class Publisher {
 public:
  static constexpr core::EndpointId usual_id = 0x1234'5678'0000'0001;
  explicit Publisher(core::Network& transport, core::EndpointId id = usual_id,
                     std::uint64_t max_bytes_per_s = 0, std::shared_ptr<core::DeliveryBook> book = {},
                     bool asynchronous = false, std::chrono::nanoseconds max_blocking = {})
      : id_(id),
        port_(transport
                  .open_writer({.id = id,
                                .type = &type_support<Image>(),
                                .max_blocking = max_blocking,
                                .max_bytes_per_s = max_bytes_per_s,
                                .asynchronous = asynchronous,
                                .book = std::move(book)})
                  .value()) {}

  struct Reader {
    core::UdpAddress address;
    std::string mask = "*";  ///< a mask, or a selection with parts
    bool reliable = false;
    std::shared_ptr<const core::Gate> gate{};  ///< not null for a reader with a maximum rate
  };
  void serve(const std::vector<Reader>& readers) {
    std::vector<core::Route> routes;
    for (const Reader& reader : readers) {
      routes.push_back({routes.size() + 1, reader.address, selection_of<Image>(reader.mask)});
      routes.back().reliable = reader.reliable;
      routes.back().gate = reader.gate;
      if (reader.gate != nullptr) routes.back().min_period_us = reader.gate->min_period_us();
    }
    port_->set_routes(std::move(routes));
  }

  /// Publishes as a program does. The data of the image is overwritten before this function returns.
  core::SendStatus publish(Image image) {
    detail::PostponedCopies postponed;
    const core::SampleHandle sample = make(image, *pool_, &postponed);
    if (!sample) return core::SendStatus::dropped;
    if (!postponed.empty()) sample->postponed = &postponed;
    const core::SendStatus status = port_->send(sample);
    if (sample->postponed != nullptr) sample->postponed = nullptr;
    std::fill(image.data.begin(), image.data.end(), std::uint8_t{0xee});
    return status;
  }
  core::SendStatus publish(const Image& image, core::BufferPool& pool) {
    const core::SampleHandle sample = make(image, pool);
    return sample ? port_->send(sample) : core::SendStatus::dropped;
  }
  /// Makes the next sample without sending it.
  core::SampleHandle make(const Image& image) { return make(image, *pool_); }
  core::SampleHandle make(const Image& image, core::BufferPool& pool,
                          detail::PostponedCopies* postponed = nullptr) {
    const FieldMask all = fields<Image>("*");
    core::SampleHandle sample = pool.take(sample_bytes(image, all));
    if (sample) fill(*sample, image, all, id_, ++sequence_, postponed);
    return sample;
  }

  core::EndpointId id() const { return id_; }
  core::NetworkWriter& port() { return *port_; }

 private:
  core::EndpointId id_;
  std::unique_ptr<core::NetworkWriter> port_;
  std::shared_ptr<core::BufferPool> pool_ = make_pool();
  std::uint64_t sequence_ = 0;
};

}  // namespace sft::udp::test
