// Passes lanes, channels and deferred work to the sending thread, and wakes that thread.
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
  /// The sending thread sleeps in `io`, which must outlive this object.
  explicit ScheduledWork(DatagramSender& io) : io_(io) {}

  // Any thread may call the following functions.

  void add(std::shared_ptr<Lane> lane);
  void add(std::shared_ptr<Channel> channel);
  /// Adds work. If the same work was added before, it must have been carried out meanwhile. Allocates
  /// nothing.
  void add(std::shared_ptr<DeferredWork> work) noexcept;
  /// Releases all work that was not taken, and ignores work that is added later. Otherwise deferred work,
  /// which shares ownership of the sending thread, would keep that thread alive.
  void close();

  // The following functions are for the sending thread.

  struct Taken {
    Taken() {
      lanes.reserve(few);
      channels.reserve(few);
    }
    std::vector<std::shared_ptr<Lane>> lanes;
    std::vector<std::shared_ptr<Channel>> channels;

    /// Memory for this number of lanes and of channels is allocated in advance.
    static constexpr std::size_t few = 16;
  };
  /// Takes the lanes and channels that were added since the last call. `taken` must be empty. If any were
  /// added, the former memory of `taken` is used for later additions.
  void take(Taken& taken);
  void carry_out_deferred() {
    if (any_deferred_.load(std::memory_order_acquire)) carry_out_all_deferred();
  }

 private:
  /// The greatest capacities of the lists of added lanes and channels so far.
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
      SFT_GUARDED_BY(mutex_);  ///< the work that was added last; each refers to the previous one
  std::atomic<bool> any_deferred_{false};
};

}  // namespace sft::udp
