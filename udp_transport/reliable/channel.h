// The samples that one writer sends reliably to one process: a ResendWindow that is shared by the threads
// that publish, send and receive acks. The lock is held for a few instructions, never during a system call.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/outgoing/writer_tally.h"
#include "udp_transport/reliable/attention.h"
#include "udp_transport/reliable/channel_life.h"
#include "udp_transport/reliable/resend_window.h"
#include "udp_transport/reliable/room_waiters.h"

namespace sft::udp {

class Channel {
 public:
  using Time = ResendWindow::Time;
  using Piece = ResendWindow::Piece;

  /// `port` is our port that receives the acks.
  Channel(std::uint32_t writer, std::uint32_t number, std::shared_ptr<Destination> to,
          std::shared_ptr<WriterTally> tally, std::uint16_t port,
          std::shared_ptr<const KeptMemory> memory = {})
      : writer_(writer),
        number_(number),
        to_(std::move(to)),
        tally_(std::move(tally)),
        port_(port),
        memory_(std::move(memory)),
        window_(writer, number, tally_->resend, 1, memory_) {}

  // Any thread may call the following functions.

  std::uint32_t writer() const { return writer_; }
  std::uint32_t number() const { return number_; }
  Destination& destination() const { return *to_; }
  WriterTally& tally() const { return *tally_; }

  struct Posted {
    std::optional<Piece> piece{};  ///< the caller sends this piece, and then calls finished() or put_back()
    Wake wake = Wake::none;
    bool waited = false;  ///< true if the call has waited until the sample could be kept
    ResendWindow::Kept kept{};
  };
  /// Posts a sample. `at_once` is true if the caller wants to send the sample itself. If `timeout` is not
  /// null, waits until the sample can be kept without giving up an older one, for at most that time, and
  /// subtracts the time of waiting from it. It also waits for a moment if the kept samples exceed a
  /// processor's caches. Otherwise a publisher that is faster than the sending would encode into memory that
  /// has left the caches.
  Posted post(JobHandle job, const FirstHeader& first, bool at_once,
              std::chrono::nanoseconds* timeout = nullptr);
  /// Posts the job only if no other sample waits to be sent. The caller then sends it. No other thread reads
  /// the job before the caller calls finished() or put_back().
  std::optional<Posted> post_ahead(const JobHandle& job, const FirstHeader& first,
                                   std::chrono::nanoseconds* timeout = nullptr);
  /// Returns true if the channel still keeps the sample: it is neither acknowledged nor given up.
  bool keeps(std::uint64_t ordinal);
  /// Waits as post() does until the job can be posted without giving up an older sample. Returns false if
  /// the job still cannot be posted without that.
  bool await_room(const Job& job, std::chrono::nanoseconds* timeout);
  /// Returns true if the job can be posted without giving up an older sample. Called by the sending thread.
  /// If the result is false, hear() wakes that thread later.
  bool has_room_or_waits(const Job& job);
  /// Returns true if a channel that keeps `bytes` has to give up samples, because all channels of the node
  /// together keep too many bytes.
  bool must_give_up_some_of(std::size_t bytes) const {
    return memory_ != nullptr && memory_->wants_some_of(bytes);
  }
  /// Posts a sample that a multicast group sends. If `kept.elsewhere` of the result is false, this channel
  /// sends the sample, too.
  Posted post_shared(JobHandle job, const FirstHeader& first, bool elsewhere);
  /// Notes that the sample was sent to the multicast group. The sending thread may then have to request acks
  /// earlier.
  [[nodiscard]] Wake departed(std::uint64_t ordinal);
  /// Returns the job of a sample that was sent to the multicast group; null for other samples.
  JobHandle sent_elsewhere(std::uint64_t ordinal);
  /// Notes that the piece was sent at about `now`. The sending thread may then have to request acks earlier,
  /// because the piece may have been sent after its last check.
  [[nodiscard]] Wake finished(const Piece& piece, Time now);
  void put_back(const Piece& piece);
  /// Notes that the publisher has sent a large sample that ends at this position of the destination's
  /// stream. Heartbeats must not overtake that sample.
  void stay_behind(std::uint64_t position) { behind_.store(position, std::memory_order_relaxed); }
  std::uint64_t behind() const { return behind_.load(std::memory_order_relaxed); }
  /// Processes an ack, which may name another channel of the writer (ResendWindow::hear()).
  [[nodiscard]] Wake hear(const Ack& ack);
  /// Returns true if the receiver has acknowledged samples that were never sent. Then this channel has
  /// ended, and the caller has to replace it by a new channel.
  bool went_wrong() const { return went_wrong_.load(std::memory_order_relaxed); }

  // The following functions are for the agent's thread.

  /// Notes that the last reader of the channel has gone.
  void end();
  /// Ends the channel at once. Called if the destination has other readers now.
  void close();
  bool closed();

  // The following functions are for the sending thread.

  std::optional<Piece> next(ResendWindow::Size size);
  struct Care {
    std::optional<Heartbeat> heartbeat{};
    Time next_look{};
    bool at_rest = false;  ///< true if the channel needs no maintenance until the next sample is posted
  };
  Care look_after();

 private:
  bool has_ended() const SFT_REQUIRES(mutex_);
  bool has_room_for(const Job& job) const SFT_REQUIRES(mutex_);
  bool runs_ahead_with(const Job& job) const SFT_REQUIRES(mutex_);
  bool wait_for_room(const Job& job, std::chrono::nanoseconds& timeout, core::Lock& lock)
      SFT_REQUIRES(mutex_);
  Wake looks_sooner(Time now) SFT_REQUIRES(mutex_);

  const std::uint32_t writer_;
  const std::uint32_t number_;
  const std::shared_ptr<Destination> to_;
  const std::shared_ptr<WriterTally> tally_;
  const std::uint16_t port_;
  const std::shared_ptr<const KeptMemory> memory_;
  std::atomic<std::uint64_t> behind_{0};
  std::atomic<bool> went_wrong_{false};

  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  ResendWindow window_ SFT_GUARDED_BY(mutex_);
  ChannelLife life_ SFT_GUARDED_BY(mutex_);
  Attention attention_ SFT_GUARDED_BY(mutex_);
  RoomWaiters waiters_ SFT_GUARDED_BY(mutex_);
  /// The number of moves of the destination that the window has taken into account.
  std::uint32_t moves_ SFT_GUARDED_BY(mutex_) = to_->moves();
};

}  // namespace sft::udp
