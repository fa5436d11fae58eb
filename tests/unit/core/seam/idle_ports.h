// Ports and transports that do nothing. Tests derive from them, and override what they check.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/seam/transport.h"

namespace sft::core {

class IdleLendingWriter : public LendingWriter {
 public:
  SendStatus send(const SampleHandle&) noexcept override { return SendStatus::sent; }
  void set_timeout(std::chrono::nanoseconds) noexcept override {}
  void set_routes(std::vector<Route>) override {}
  SampleHandle loan(std::size_t) noexcept override { return {}; }
  std::size_t largest_loan_bytes() const noexcept override { return SIZE_MAX; }
  bool can_send(const SampleBuffer&) const noexcept override { return true; }
  bool owns(const SampleBuffer&) const noexcept override { return false; }
  std::chrono::nanoseconds time_left() const noexcept override { return {}; }
  std::string why_unreachable(const Route&) override { return {}; }
  std::optional<std::uint64_t> held_back(EndpointId) noexcept override { return {}; }
  bool begin_with(const Route&, const std::vector<SampleHandle>&, std::uint64_t) override { return false; }
};

class IdleNetworkWriter : public NetworkWriter {
 public:
  SendStatus send(const SampleHandle& sample) noexcept override {
    begin_sample();
    return send_begun(sample, Reach::usual_routes);
  }
  void set_timeout(std::chrono::nanoseconds) noexcept override {}
  void set_routes(std::vector<Route>) override {}
  bool takes_postponed() const noexcept override { return false; }
  void send_history(const Route&, std::vector<SampleHandle>) override {}
  bool history_sent(EndpointId) noexcept override { return true; }
  Counters counters() const noexcept override { return {}; }
  std::string multicast(EndpointId) const override { return {}; }
  std::string path_trouble(EndpointId) const override { return {}; }

 protected:
  void begin_sample() noexcept override {}
  SendStatus send_begun(const SampleHandle&, Reach) noexcept override { return SendStatus::sent; }
  void miss_begun() noexcept override {}
  void hold(BatchTimeout) noexcept override {}
  std::size_t flush() noexcept override { return 0; }
};

/// The functions that both kinds of readers have in common.
template <class Port>
class IdleReader : public Port {
 public:
  SampleHandle take() noexcept override { return {}; }
  Result<void> connect(const Source&) override { return {}; }
  bool connected(EndpointId) const noexcept override { return true; }
  void disconnect(EndpointId) noexcept override {}
  HistoryProgress history(EndpointId) const noexcept override { return HistoryProgress::came; }
  std::uint64_t arrivals(EndpointId) noexcept override { return 0; }
  ReaderPort::Counters counters() const noexcept override { return {}; }
};

class IdleBorrowingReader : public IdleReader<BorrowingReader> {
 public:
  SampleHandle take_of(EndpointId) noexcept override { return {}; }
  bool some_wait() const noexcept override { return false; }
  void notify_room() noexcept override {}
  std::uint64_t held_too_many() const noexcept override { return 0; }
};

class IdleNetworkReader : public IdleReader<NetworkReader> {
 public:
  bool receive(const Waiting&) noexcept override { return false; }
  void share_reader() override {}
  void announced(const Source&) override {}
  void accept(std::vector<Accepted>) override {}
};

/// The functions that both kinds of transports have in common. This transport opens no ports.
template <class Kind, class Writer, class Reader>
class IdleTransport : public Kind {
 public:
  Availability poll(std::chrono::steady_clock::time_point) override { return Availability::ready; }
  std::size_t max_sample_bytes() const noexcept override { return 1 << 20; }
  std::string description() const override { return "test"; }
  Transport::Counters counters() const noexcept override { return {}; }
  Result<Writer> open_writer(const WriterSpec&) override { return nullptr; }
  Result<std::unique_ptr<Reader>> open_reader(const ReaderSpec&) override { return nullptr; }
};

class IdleSharedMemory : public IdleTransport<SharedMemory, std::shared_ptr<LendingWriter>, BorrowingReader> {
 public:
  HostToken host_token() const override { return {}; }
  bool may_write() const override { return true; }
  bool lacks_daemon() const override { return false; }
  std::uint32_t max_depth() const noexcept override { return UINT32_MAX; }
};

class IdleNetwork : public IdleTransport<Network, std::unique_ptr<NetworkWriter>, NetworkReader> {
 public:
  std::vector<UdpAddress> addresses() const override { return {}; }
  std::vector<Link> links() const override { return {}; }
  bool network_changed() noexcept override { return true; }
  void wake_receiver() noexcept override {}
  std::chrono::steady_clock::time_point next_poll() const override {
    return std::chrono::steady_clock::time_point::max();
  }
  void add_to(NodeStatus&) const override {}
};

}  // namespace sft::core
