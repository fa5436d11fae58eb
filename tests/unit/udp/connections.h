// Connections that send nothing to the network. Tests check which connections were made and which datagrams
// were sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/flow/connection_pair.h"
#include "udp_transport/flow/destination.h"

namespace sft::udp::test {

class Connections {
 public:
  Connect connect() {
    return [this](const SocketAddress&) { return std::make_unique<Nowhere>(*this); };
  }
  std::size_t open() const { return open_; }
  std::size_t reconnected() const { return reconnected_; }
  /// Returns the number of times that the sending thread was woken.
  std::size_t woken() const { return woken_; }
  const std::vector<SocketAddress>& redirected() const { return redirected_; }
  /// Returns the datagrams that were sent.
  const std::vector<Bytes>& sent() const { return sent_; }
  /// Returns the answer of a receiver to the last flow mark that was sent.
  FlowReport answer_to_mark(std::uint32_t window_bytes = 1'000'000) const {
    std::optional<FlowMark> last;
    for (const Bytes& bytes : sent_) {
      if (const auto mark = parse_as<FlowMark>(bytes)) last = mark;
    }
    if (!last) return {};
    return {.flow = last->flow,
            .position = last->position,
            .window_bytes = window_bytes,
            .datagrams = last->datagrams,
            .came = last->datagrams,
            .sent_at_ns = last->sent_at_ns};
  }
  /// Makes connections send the next `count` batches. Later batches get the outcome `then`, by default that
  /// the send buffer is full.
  void take_batches(std::size_t count, SendOutcome then = SendOutcome::would_wait) {
    batches_left_ = count;
    then_ = then;
  }
  /// Sets a function that is called after each batch is sent.
  void behind_each(std::function<void()> act) { behind_each_ = std::move(act); }

 private:
  friend class NoSender;
  class Nowhere final : public Connection {
   public:
    explicit Nowhere(Connections& all) : all_(all) { ++all_.open_; }
    ~Nowhere() override { --all_.open_; }
    Sent try_send(std::span<const OutgoingBatch> batches) noexcept override {
      Sent sent;
      for (; sent.batches < batches.size(); ++sent.batches) {
        if (all_.batches_left_ == 0) return {sent.batches, all_.then_};
        --all_.batches_left_;
        append_datagrams(batches[sent.batches].parts, batches[sent.batches].segment_bytes, all_.sent_);
        if (all_.behind_each_) all_.behind_each_();
      }
      return sent;
    }
    void reconnect() noexcept override { ++all_.reconnected_; }
    void redirect(const SocketAddress& to) noexcept override { all_.redirected_.push_back(to); }
    void wait_for_room() noexcept override {}
    bool full() const noexcept override { return false; }

   private:
    Connections& all_;
  };
  std::function<void()> behind_each_;
  std::vector<Bytes> sent_;
  std::size_t batches_left_ = SIZE_MAX;
  SendOutcome then_ = SendOutcome::would_wait;
  std::size_t open_ = 0;
  std::size_t reconnected_ = 0;
  std::size_t woken_ = 0;
  std::vector<SocketAddress> redirected_;
};

/// A sender that only makes connections of a `Connections` object. Its other functions do nothing.
class NoSender : public DatagramSender {
 public:
  explicit NoSender(Connections& connections) : connections_(connections) {}
  std::unique_ptr<Connection> connect(const SocketAddress& to) override { return connections_.connect()(to); }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress&) override {
    return connect(group);
  }
  void await(std::chrono::steady_clock::time_point) noexcept override {}
  void send_to(const SocketAddress&, std::span<const std::byte>) noexcept override {}
  void wake() noexcept override { ++connections_.woken_; }

 private:
  Connections& connections_;
};

/// Sends a datagram of the present maximum length of the path. The receiver then reports `longest` as the
/// length of the longest datagram that has arrived.
inline void report_longest(Destination& to, const Connections& sent, std::size_t longest,
                           Destination::Time now) {
  to.asked_again();
  to.sent(to.connection(), to.path().datagram_bytes(), 1, to.path().datagram_bytes(), now);
  FlowReport report = sent.answer_to_mark();
  report.flow = to.flow();
  report.longest = static_cast<std::uint32_t>(longest);
  static_cast<void>(to.hear(report, to.path().address().ip, now));
}

/// Sends a datagram of the present maximum length of the path. The receiver reports that the datagram has
/// arrived.
inline void report_all(Destination& to, const Connections& sent, Destination::Time now) {
  report_longest(to, sent, to.path().datagram_bytes(), now);
}

/// Simulates a path that loses all datagrams longer than a flow mark. The receiver keeps reporting that the
/// longest arrived datagram has the length of a flow mark, until the sender limits the length of datagrams.
/// Returns the time of that.
inline Destination::Time lose_long_ones(Destination& to, const Connections& sent, Destination::Time now) {
  report_longest(to, sent, 0, now);  // the first report; no datagram has arrived before it
  for (int i = 0; i <= 2 * PathMtu::losses_max && to.path().limited_to() == 0; ++i)
    report_longest(to, sent, mark_bytes, now += PathMtu::timeout);
  return now;
}

}  // namespace sft::udp::test
