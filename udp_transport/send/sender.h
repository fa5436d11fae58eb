// The sending thread: takes what publishers queued and sends it, as fast as each destination takes it. No
// destination waits for another: where a send buffer is full, what has room goes on. Small samples go before
// large ones, and these take turns.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/platform/thread.h"
#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"

namespace sft::udp {

/// Work that a publisher's thread has handed over to the sending thread.
class DeferredWork {
 public:
  virtual ~DeferredWork() = default;
  virtual void carry_out() noexcept = 0;

 private:
  friend class Sender;
  std::shared_ptr<DeferredWork> next_;  ///< while the work is scheduled
};

class Sender {
 public:
  /// Sends at most so many bytes per second; 0: no limit.
  explicit Sender(std::unique_ptr<DatagramSender> io, std::uint64_t max_bytes_per_s = 0);
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  /// Hears what comes back to answer_port(), on the sending thread, as hear_answer() does.
  using Hear = std::function<Wake(std::span<const std::byte> datagram, const SocketAddress& from,
                                  std::chrono::steady_clock::time_point)>;
  Result<void> start(const core::ThreadSpec& thread, Hear hear = {});
  /// What is queued is not sent any more. Not called by the sending thread.
  void stop();
  bool stopped() const { return stopped_.load(std::memory_order_acquire); }

  // Any thread.

  std::unique_ptr<Connection> connect(const SocketAddress& to) { return io_->connect(to); }
  /// Sends one datagram without a connection, at once or not at all.
  void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept {
    io_->send_to(to, datagram);
  }
  RateLimit& limit() { return limit_; }
  /// So many socket bytes of one sample may go to the destination now, by its window and by the limits of the
  /// writer and of all writers.
  std::size_t allowance(Destination& to, RateLimit& of_writer, ResendWindow::Size size,
                        std::chrono::steady_clock::time_point now);
  /// 0: there is none.
  std::uint16_t answer_port() const { return io_->answer_port(); }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) {
    return io_->connect_group(group, own);
  }
  /// A lane that was idle has something to send.
  void schedule(std::shared_ptr<Lane> lane);
  /// A channel that was at rest has something to look after.
  void schedule(std::shared_ptr<Channel> channel);
  /// Work must be carried out before it is scheduled again. Allocates nothing.
  void schedule(std::shared_ptr<DeferredWork> work) noexcept;
  /// Lanes were closed, or channels have something to send: looks at all of them at once.
  void look_again() noexcept { io_->wake(); }
  /// Tells the sending thread what it has to know of a lane, a channel or work.
  template <class One>
  void wake(Wake wake, const std::shared_ptr<One>& one) {
    if (wake == Wake::schedule) return schedule(one);
    if (wake == Wake::look) look_again();
  }
  /// The same, where there is nothing to schedule.
  void wake(Wake wake) noexcept {
    if (wake != Wake::none) look_again();
  }

 private:
  using Time = std::chrono::steady_clock::time_point;
  using Size = ResendWindow::Size;
  struct Flow {  ///< the present job of one lane, or of one of a channel's two queues
    std::shared_ptr<Lane> lane;
    std::optional<Fragmenter> fragments{};
    std::optional<Time> full_since{};  ///< its connection, without anything sent since
    std::shared_ptr<Channel> channel{};
    bool waits_for_room = false;  ///< the lane's current job, in the lane's channel
    Size size{};
    std::uint64_t behind = 0;  ///< the destination's position after what was sent last of a large sample
    std::optional<Channel::Piece> piece{};  ///< keeps what the fragments refer to
    Destination& destination() const { return lane ? lane->destination() : channel->destination(); }
    WriterTally& tally() const { return lane ? lane->tally() : channel->tally(); }
    Connection& connection() const;
  };
  struct Attended {
    std::shared_ptr<Channel> channel;
    Flow small, large;
  };
  enum class Progress : std::uint8_t {
    none,   ///< it has to wait
    some,   ///< and there is more
    whole,  ///< all has left
    lost,
  };
  static bool is_under_way(Progress progress) {
    return progress == Progress::none || progress == Progress::some;
  }

  void run();
  void hear_answers();
  void carry_out_deferred();
  void take_over_scheduled();
  void send_small();
  void send_large();
  void forget_finished();
  bool begin(Flow& flow);
  void advance(Flow& flow);
  bool pass_on(Flow& flow);
  void look_after(Attended& attended);
  void advance_channel(Flow& flow);
  void send(const Heartbeat& heartbeat, const Attended& attended);
  bool must_wait(const Flow& flow) const;
  Progress send_some(Flow& flow);
  Progress send_a_few(Flow& flow);
  std::size_t cut_batches(Flow& flow, Time now);
  void wait_for_allowance(Flow& flow, Time now);
  void account_for(Flow& flow, Connection& by, std::size_t batches, Time now);
  Progress wait_for_room(Flow& flow, Connection& by, Time now);

  static constexpr int calls_per_turn = 8;  ///< then it is the turn of the next flow
  static constexpr std::size_t batches_per_call = 8;
  /// Socket bytes: what was cut is still in the nearest caches when the kernel copies it, and a receiver that
  /// sleeps is woken by the first.
  static constexpr std::size_t bytes_per_call = batch_bytes_max;

  std::unique_ptr<DatagramSender> io_;
  RateLimit limit_;
  Hear hear_;
  std::thread thread_;
  std::atomic<bool> stopped_{false};

  std::mutex mutex_;
  std::vector<std::shared_ptr<Lane>> scheduled_;              ///< not yet seen by the thread
  std::vector<std::shared_ptr<Channel>> scheduled_channels_;  ///< not yet seen by the thread
  std::shared_ptr<DeferredWork> deferred_;  ///< not yet seen by the thread; the last one knows the one before
  std::atomic<bool> any_deferred_{false};

  // Used by the sending thread alone.
  std::vector<std::shared_ptr<Lane>> taken_;
  std::vector<Flow> flows_;
  std::vector<std::shared_ptr<Channel>> taken_channels_;
  std::vector<Attended> attended_;
  std::size_t turn_ = 0;  ///< which large one is the first
  Time wake_at_{};        ///< when the next flow may go on
  // The batches of the present call.
  std::array<Batch, batches_per_call> batches_;
  std::array<OutgoingBatch, batches_per_call> outgoing_;
  std::array<std::optional<Fragmenter>, batches_per_call> rest_;  ///< what is left behind each batch
};

}  // namespace sft::udp
