// Decorators of the I/O interfaces: receivers that lose, repeat and swap datagrams, and connections that are
// full or refuse to send.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp::test {

struct Faults {
  double loss = 0;
  double repetition = 0;
  double swap = 0;  ///< the probability that a datagram is swapped with the next one
  /// Faults happen only while the flag is true. The flag must outlive the I/O. If the pointer is null, faults
  /// may happen at any time.
  const std::atomic<bool>* only_while = nullptr;

  bool may_happen() const { return only_while == nullptr || *only_while; }
};

/// Passes all datagrams on. The base class of receivers that check or lose datagrams.
class PassingReceiver : public DatagramReceiver, private DatagramSink {
 public:
  explicit PassingReceiver(std::unique_ptr<DatagramReceiver> inner) : inner_(std::move(inner)) {}

  bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept override {
    sink_ = &sink;
    return inner_->receive(*this, deadline, spin);
  }
  bool receive_now(DatagramSink& sink) noexcept override {
    sink_ = &sink;
    return inner_->receive_now(*this);
  }
  bool receive_from_groups(DatagramSink& sink) noexcept override {
    sink_ = &sink;
    return inner_->receive_from_groups(*this);
  }
  Descriptors descriptors() const noexcept override { return inner_->descriptors(); }
  void wake() noexcept override { inner_->wake(); }
  void finish() noexcept override { inner_->finish(); }

 protected:
  void pass_on(std::span<const std::byte> bytes, const SocketAddress& from) { sink_->datagram(bytes, from); }

 private:
  void begin(ArrivalTime now) noexcept override { sink_->begin(now); }
  void end() noexcept override { sink_->end(); }

  std::unique_ptr<DatagramReceiver> inner_;
  DatagramSink* sink_ = nullptr;
};

class FaultyReceiver final : public PassingReceiver {
 public:
  FaultyReceiver(std::unique_ptr<DatagramReceiver> inner, const Faults& faults, unsigned seed)
      : PassingReceiver(std::move(inner)), faults_(faults), random_(seed) {}

 private:
  bool happens(double probability) {
    return faults_.may_happen() && std::uniform_real_distribution<>()(random_) < probability;
  }

  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
    if (happens(faults_.loss)) return;
    if (!held_ && happens(faults_.swap)) {
      held_.emplace(bytes.begin(), bytes.end());
      return;
    }
    pass_on(bytes, from);
    if (happens(faults_.repetition)) pass_on(bytes, from);
    if (held_) pass_on(*std::exchange(held_, {}), from);
  }

  Faults faults_;
  std::mt19937 random_;
  std::optional<std::vector<std::byte>> held_;
};

/// While `unreached` is true, this receiver gets no datagrams that were sent to a group.
class UnreachedReceiver final : public PassingReceiver {
 public:
  UnreachedReceiver(std::unique_ptr<DatagramReceiver> inner, const std::atomic<bool>& unreached)
      : PassingReceiver(std::move(inner)), unreached_(unreached) {}

 private:
  void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
    const auto d = parse(bytes);
    const bool of_group = d && d->kind == DatagramKind::first && (d->first.flags & group_follows) != 0;
    if (!unreached_ || !of_group) pass_on(bytes, from);
  }

  const std::atomic<bool>& unreached_;
};

/// Keeps a receiving thread busy in one datagram. Records the sockets from which samples arrive, in order.
class Hold {
 public:
  void begin() {
    {
      const std::scoped_lock lock(mutex_);
      arrivals_.clear();
    }
    held_ = true;
  }
  /// Returns true while the receiving thread is kept busy.
  bool stops_it() const { return stopped_; }
  void end() {
    held_ = false;
    held_.notify_all();
  }
  /// Returns the arrivals since begin(), such as "7 by group, 8 alone".
  std::string arrivals() const {
    const std::scoped_lock lock(mutex_);
    return arrivals_;
  }

  DatagramIo put_around(DatagramIo io) {
    io.receiver = std::make_unique<Held>(std::move(io.receiver), *this);
    return io;
  }

 private:
  class Held final : public PassingReceiver {
   public:
    Held(std::unique_ptr<DatagramReceiver> inner, Hold& hold)
        : PassingReceiver(std::move(inner)), hold_(hold) {}

   private:
    void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept override {
      hold_.stopped_ = hold_.held_.load();
      hold_.held_.wait(true);
      hold_.stopped_ = false;
      hold_.note(bytes);
      pass_on(bytes, from);
    }
    Hold& hold_;
  };

  void note(std::span<const std::byte> bytes) {
    const auto d = parse(bytes);
    if (!d) return;
    const std::scoped_lock lock(mutex_);
    if (!arrivals_.empty()) arrivals_ += ", ";
    arrivals_ += std::to_string(d->label().sequence);
    arrivals_ += (d->first.flags & group_follows) != 0 ? " by group" : " alone";
  }

  std::atomic<bool> held_{false}, stopped_{false};
  mutable std::mutex mutex_;
  std::string arrivals_;
};

/// Passes all datagrams on. The base class of connections with faults.
class Connected : public Connection {
 public:
  explicit Connected(std::unique_ptr<Connection> inner) : inner_(std::move(inner)) {}
  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    return inner_->try_send(batches);
  }
  void reconnect() noexcept override { inner_->reconnect(); }
  void redirect(const SocketAddress& to) noexcept override { inner_->redirect(to); }
  void wait_for_room() noexcept override { inner_->wait_for_room(); }
  bool full() const noexcept override { return inner_->full(); }

 private:
  std::unique_ptr<Connection> inner_;
};

/// A function that puts a decorator around each connection of a sender.
using DecorateConnection =
    std::function<std::unique_ptr<Connection>(const SocketAddress&, std::unique_ptr<Connection>)>;

/// Passes all calls on. The base class of senders with faults.
class PassingSender : public DatagramSender {
 public:
  explicit PassingSender(std::unique_ptr<DatagramSender> inner) : inner_(std::move(inner)) {}

  std::unique_ptr<Connection> connect(const SocketAddress& to) override { return inner_->connect(to); }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) override {
    return inner_->connect_group(group, own);
  }
  void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept override {
    inner_->send_to(to, datagram);
  }
  std::uint16_t answer_port() const noexcept override { return inner_->answer_port(); }
  Answer take_answer(std::span<std::byte> to) noexcept override { return inner_->take_answer(to); }
  void await(std::chrono::steady_clock::time_point deadline) noexcept override { inner_->await(deadline); }
  void wake() noexcept override { inner_->wake(); }

 private:
  std::unique_ptr<DatagramSender> inner_;
};

class DecoratedSender final : public PassingSender {
 public:
  DecoratedSender(std::unique_ptr<DatagramSender> inner, DecorateConnection decorate)
      : PassingSender(std::move(inner)), decorate_(std::move(decorate)) {}
  std::unique_ptr<Connection> connect(const SocketAddress& to) override {
    return decorate_(to, PassingSender::connect(to));
  }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) override {
    return decorate_(group, PassingSender::connect_group(group, own));
  }

 private:
  DecorateConnection decorate_;
};

/// A sender that loses some received answers, and takes some answers twice.
class SenderOfBadLink final : public PassingSender {
 public:
  SenderOfBadLink(std::unique_ptr<DatagramSender> inner, const Faults& faults, unsigned seed)
      : PassingSender(std::move(inner)), faults_(faults), random_(seed) {}

  Answer take_answer(std::span<std::byte> to) noexcept override {
    if (!again_.empty()) {
      const std::vector<std::byte> same = std::exchange(again_, {});
      std::ranges::copy(same, to.begin());
      return {same.size(), again_from_};
    }
    Answer answer = PassingSender::take_answer(to);
    while (answer.bytes > 0 && happens(faults_.loss)) answer = PassingSender::take_answer(to);
    if (happens(faults_.repetition)) {
      again_.assign(to.begin(), to.begin() + static_cast<std::ptrdiff_t>(answer.bytes));
      again_from_ = answer.from;
    }
    return answer;
  }

 private:
  bool happens(double probability) {
    return faults_.may_happen() && std::uniform_real_distribution<>()(random_) < probability;
  }

  Faults faults_;
  std::mt19937 random_;
  std::vector<std::byte> again_;
  SocketAddress again_from_;
};

/// Adds faults to all received datagrams: to samples, and to answers to sent samples.
inline DatagramIo with_faults(DatagramIo io, const Faults& faults, unsigned seed) {
  io.receiver = std::make_unique<FaultyReceiver>(std::move(io.receiver), faults, seed);
  io.sender = std::make_unique<SenderOfBadLink>(std::move(io.sender), faults, ~seed);
  return io;
}

/// Simulates the send buffer for one address. The buffer is full until the gate is opened.
class Gate {
 public:
  explicit Gate(std::uint16_t port) : port_(port) {}

  void open() {
    open_ = true;
    if (DatagramSender* sender = sender_; sender != nullptr) sender->wake();
  }
  void close() { open_ = false; }
  bool has_waiting() const { return waiting_; }

  DatagramIo put_around(DatagramIo io) {
    auto sender = std::make_unique<DecoratedSender>(
        std::move(io.sender), [this](const SocketAddress& to, std::unique_ptr<Connection> inner) {
          if (to.port == port_) inner = std::make_unique<Gated>(std::move(inner), *this);
          return inner;
        });
    sender_ = sender.get();
    io.sender = std::move(sender);
    return io;
  }

 private:
  class Gated final : public Connected {
   public:
    Gated(std::unique_ptr<Connection> inner, Gate& gate) : Connected(std::move(inner)), gate_(gate) {}
    Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
      return gate_.open_ ? Connected::try_send(batches) : Sent{0, SendOutcome::would_wait};
    }
    void wait_for_room() noexcept override {
      if (full()) gate_.waiting_ = true;
      if (gate_.open_) Connected::wait_for_room();
    }
    bool full() const noexcept override { return !gate_.open_ || Connected::full(); }

   private:
    Gate& gate_;
  };

  const std::uint16_t port_;
  std::atomic<bool> open_{false}, waiting_{false};
  std::atomic<DatagramSender*> sender_{nullptr};
};

/// A connection that is full at every other call, and sends one batch at each call in between.
class BusyConnection final : public Connected {
 public:
  using Connected::Connected;
  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    if (++calls_ % 2 != 0) return {0, SendOutcome::would_wait};
    Sent sent = Connected::try_send(batches.first(1));
    if (sent.batches < batches.size() && sent.outcome == SendOutcome::sent)
      sent.outcome = SendOutcome::would_wait;
    return sent;
  }

 private:
  std::atomic<unsigned> calls_{0};
};

/// A connection that refuses batches of several datagrams.
template <SendOutcome refusal>
class TrainRefusingConnection final : public Connected {
 public:
  using Connected::Connected;
  Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
    const bool trains = std::any_of(batches.begin(), batches.end(),
                                    [](const OutgoingBatch& batch) { return batch.segment_bytes != 0; });
    return trains ? Sent{0, refusal} : Connected::try_send(batches);
  }
};

template <class Faulty>
DatagramIo with_connections(DatagramIo io) {
  io.sender = std::make_unique<DecoratedSender>(std::move(io.sender),
                                                [](const SocketAddress&, std::unique_ptr<Connection> inner) {
                                                  return std::make_unique<Faulty>(std::move(inner));
                                                });
  return io;
}

}  // namespace sft::udp::test
