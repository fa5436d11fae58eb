// Decorators of the I/O seam: a receiver whose datagrams get lost,
// repeated and swapped, and a sender that waits.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "udp_transport/datagram_io.h"

namespace sft::udp::test {

struct Faults {
  double loss = 0;
  double repetition = 0;
  double swap = 0;  ///< with the datagram after it
};

class FaultyReceiver final : public DatagramReceiver, private DatagramSink {
 public:
  FaultyReceiver(std::unique_ptr<DatagramReceiver> inner, const Faults& faults, unsigned seed)
      : inner_(std::move(inner)), faults_(faults), random_(seed) {}

  bool receive(DatagramSink& sink, std::chrono::steady_clock::time_point deadline) noexcept override {
    sink_ = &sink;
    return inner_->receive(*this, deadline);
  }
  void wake() noexcept override { inner_->wake(); }
  void finish() noexcept override { inner_->finish(); }

 private:
  bool happens(double probability) { return std::uniform_real_distribution<>()(random_) < probability; }

  void begin(ArrivalTime now) noexcept override { sink_->begin(now); }
  void end() noexcept override { sink_->end(); }
  void datagram(std::span<const std::byte> bytes, SocketAddress from) noexcept override {
    if (happens(faults_.loss)) return;
    if (!held_ && happens(faults_.swap)) {
      held_.emplace(bytes.begin(), bytes.end());
      return;
    }
    sink_->datagram(bytes, from);
    if (happens(faults_.repetition)) sink_->datagram(bytes, from);
    if (held_) sink_->datagram(*std::exchange(held_, {}), from);
  }

  std::unique_ptr<DatagramReceiver> inner_;
  Faults faults_;
  std::mt19937 random_;
  std::optional<std::vector<std::byte>> held_;
  DatagramSink* sink_ = nullptr;
};

/// A gate that the sending thread waits at.
class Gate {
 public:
  void open() {
    {
      const std::scoped_lock lock(mutex_);
      open_ = true;
    }
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return open_; });
  }
  void await_somebody() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_ > 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  int waiting_ = 0;
};

class GatedSender final : public DatagramSender {
 public:
  GatedSender(std::unique_ptr<DatagramSender> inner, Gate& gate) : inner_(std::move(inner)), gate_(gate) {}
  SendOutcome try_send(const OutgoingBatch& batch) noexcept override { return inner_->try_send(batch); }
  SendOutcome send(std::span<const OutgoingBatch> batches) noexcept override {
    gate_.pass();
    return inner_->send(batches);
  }
  void stop() noexcept override { inner_->stop(); }
  void finish() noexcept override { inner_->finish(); }

 private:
  std::unique_ptr<DatagramSender> inner_;
  Gate& gate_;
};

/// Answers try_send() as a full send buffer does.
class BusySender final : public DatagramSender {
 public:
  explicit BusySender(std::unique_ptr<DatagramSender> inner) : inner_(std::move(inner)) {}
  SendOutcome try_send(const OutgoingBatch&) noexcept override { return SendOutcome::would_wait; }
  SendOutcome send(std::span<const OutgoingBatch> batches) noexcept override { return inner_->send(batches); }
  void stop() noexcept override { inner_->stop(); }
  void finish() noexcept override { inner_->finish(); }

 private:
  std::unique_ptr<DatagramSender> inner_;
};

/// A way out that takes one datagram at a time.
class SegmentRefusingSender final : public DatagramSender {
 public:
  explicit SegmentRefusingSender(std::unique_ptr<DatagramSender> inner) : inner_(std::move(inner)) {}
  SendOutcome try_send(const OutgoingBatch& batch) noexcept override {
    return batch.segment_bytes != 0 ? SendOutcome::no_segments : inner_->try_send(batch);
  }
  SendOutcome send(std::span<const OutgoingBatch> batches) noexcept override {
    for (const OutgoingBatch& batch : batches) {
      if (batch.segment_bytes != 0) return SendOutcome::no_segments;
    }
    return inner_->send(batches);
  }
  void stop() noexcept override { inner_->stop(); }
  void finish() noexcept override { inner_->finish(); }

 private:
  std::unique_ptr<DatagramSender> inner_;
};

}  // namespace sft::udp::test
