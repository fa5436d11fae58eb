// Hands lanes, channels and deferred work over to the sending thread, and wakes that thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/send/deferred_work.h"

namespace sft::udp {

class ScheduledWork {
 public:
  /// The sending thread sleeps in `io`, which outlives this object.
  explicit ScheduledWork(DatagramSender& io) : io_(io) {}

  // Any thread.

  void add(std::shared_ptr<Lane> lane);
  void add(std::shared_ptr<Channel> channel);
  /// Adds work, which must have been carried out before it is added again. Allocates nothing.
  void add(std::shared_ptr<DeferredWork> work) noexcept;
  /// Releases everything that was not taken, and ignores what is added later, because deferred work shares
  /// ownership of the sending thread.
  void close();

  // The sending thread.

  struct Taken {
    Taken() {
      lanes.reserve(few);
      channels.reserve(few);
    }
    std::vector<std::shared_ptr<Lane>> lanes;
    std::vector<std::shared_ptr<Channel>> channels;

    static constexpr std::size_t few = 16;  ///< for this many lanes or channels nothing is allocated later
  };
  /// Takes the lanes and channels that were added since the last call. `taken` is empty before. If
  /// something is taken, its former memory is used for what is added next.
  void take(Taken& taken);
  void carry_out_deferred() {
    if (any_deferred_.load(std::memory_order_acquire)) carry_out_all_deferred();
  }

 private:
  /// The capacities that these lists have reached.
  struct Room {
    std::size_t lanes = 0, channels = 0;
  };

  void carry_out_all_deferred();

  DatagramSender& io_;
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  bool is_closed_ SFT_GUARDED_BY(mutex_) = false;
  Taken added_ SFT_GUARDED_BY(mutex_);
  Room room_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<DeferredWork> deferred_
      SFT_GUARDED_BY(mutex_);  ///< the last work added; each one knows the one before
  std::atomic<bool> any_deferred_{false};
};

}  // namespace sft::udp
