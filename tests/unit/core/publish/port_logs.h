// Ports that record the calls of a publisher, and samples to send through these ports.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/vanilla_port.h"
#include "sft/detail/sample_format.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core::test {

/// A port that records each call as a word.
class NetworkLog final : public IdleNetworkWriter {
 public:
  SendStatus send(const SampleHandle&) noexcept override { return note("send", answer); }
  void set_routes(std::vector<Route> routes) override { note("routes " + std::to_string(routes.size()), 0); }
  bool takes_postponed() const noexcept override { return true; }
  void send_history(const Route& to, std::vector<SampleHandle> samples) override {
    note("history of " + std::to_string(samples.size()) + " to " + std::to_string(to.reader), 0);
  }
  bool history_sent(EndpointId) noexcept override { return all_left; }
  void begin_local_turn() noexcept override { note("local turn", 0); }
  void end_local_turn() noexcept override { note("local turn over", 0); }

  std::vector<std::string> take() { return std::exchange(calls_, {}); }

  SendStatus answer = SendStatus::sent;
  bool all_left = true;

 private:
  void begin_sample() noexcept override { note("begin", 0); }
  SendStatus send_begun(const SampleHandle&, Reach reach) noexcept override {
    return note(reach == Reach::usual_routes ? "send begun" : "send begun, by fallbacks too", answer);
  }
  void miss_begun() noexcept override { note("miss", 0); }
  void hold(BatchTimeout) noexcept override { note("hold", 0); }
  std::size_t flush() noexcept override { return note("flush", std::size_t{0}); }

  template <class Result>
  Result note(std::string call, Result result) {
    calls_.push_back(std::move(call));
    return result;
  }

  std::vector<std::string> calls_;
};

/// A port that lends memory from a pool, and keeps the samples that are sent.
class MemoryLog final : public IdleLendingWriter {
 public:
  SampleHandle loan(std::size_t bytes) noexcept override {
    return is_full ? SampleHandle() : memory_->take(bytes);
  }
  std::size_t largest_loan_bytes() const noexcept override { return largest_bytes; }
  bool can_send(const SampleBuffer& sample) const noexcept override { return owns(sample); }
  bool owns(const SampleBuffer& sample) const noexcept override { return sample.owner == memory_; }
  SendStatus send(const SampleHandle& sample) noexcept override {
    sent.push_back(sample);
    return answer;
  }
  /// Simulates a late reader that waits for its history. During each of the first `interruptions` attempts
  /// a sample is published and held back, so that begin_with() fails.
  std::optional<std::uint64_t> held_back(EndpointId) noexcept override {
    return given ? std::nullopt : std::optional(interruptions);
  }
  bool begin_with(const Route&, const std::vector<SampleHandle>& retained, std::uint64_t before) override {
    if (before > 0) {
      --interruptions;
      return false;
    }
    given = retained;
    return true;
  }

  bool is_full = false;
  std::size_t largest_bytes = std::size_t{1} << 20;
  SendStatus answer = SendStatus::sent;
  std::uint64_t interruptions = 0;
  std::vector<SampleHandle> sent;
  std::optional<std::vector<SampleHandle>> given;

 private:
  const std::shared_ptr<BufferPool> memory_ = BufferPool::make(std::size_t{1} << 20);
};

/// A port that keeps the samples that it gets.
class VanillaLog final : public VanillaPort {
 public:
  void send(const SampleHandle& sample) noexcept override { sent.push_back(sample); }
  void begin_with(std::vector<SampleHandle> samples) override { retained = std::move(samples); }
  std::size_t readers() const noexcept override { return 1; }

  std::vector<SampleHandle> sent;
  std::optional<std::vector<SampleHandle>> retained;
};

/// Returns a sample of that type with all fields and a small body.
inline SampleHandle make_sample(BufferPool& pool, const TypeSupport& type, std::uint64_t sequence = 0) {
  constexpr std::uint32_t body_bytes = 8;
  const detail::SampleLayout layout(type.index_slots());
  SampleHandle sample = pool.take(layout.bytes(body_bytes));
  sample->header().body_offset = static_cast<std::uint32_t>(layout.body_offset);
  sample->header().body_bytes = body_bytes;
  sample->header().sequence = sequence;
  sample->mask = type.full();
  sample->trust_header();
  return sample;
}

inline Route network_route(EndpointId reader, const TypeSupport& type) {
  return {.reader = reader, .destination = UdpAddress{0x7f000001, 5000}, .selection = type.full()};
}
inline Route memory_route(EndpointId reader, const TypeSupport& type) {
  return {.reader = reader, .destination = DoorbellAddress{}, .selection = type.full()};
}

}  // namespace sft::core::test
