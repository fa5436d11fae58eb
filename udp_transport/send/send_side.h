// The state that the writers of one transport share.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/platform/network_monitor.h"
#include "core/seam/buffer_pool.h"
#include "core/sync/guarded_call.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/destination_directory.h"
#include "udp_transport/io/multicast_links.h"
#include "udp_transport/multicast/multicast_group.h"
#include "udp_transport/outgoing/kept_memory.h"
#include "udp_transport/reliable/channel_directory.h"
#include "udp_transport/send/sender.h"

namespace sft::udp {

/// A task that the agent's thread has to perform from time to time.
class Periodic {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Performs the task. Returns the time by which this function must be called again; Time::max(): at no
  /// certain time.
  virtual Time maintain(Time now) = 0;

 protected:
  ~Periodic() = default;
};

/// Any thread may call the functions, except where a comment names a thread.
class PeriodicTasks {
 public:
  using Time = Periodic::Time;

  void add(Periodic& one) {
    const core::Lock lock(mutex_);
    const auto maintain = [&one](Time now, Time& next) { next = std::min(next, one.maintain(now)); };
    all_.push_back({&one, std::make_shared<Maintain>(maintain)});
  }
  /// Removes a task. After the return, the task is not called any more, and no call of it is in progress.
  void remove(const Periodic& one) {
    core::Lock lock(mutex_);
    const auto found = std::ranges::find(all_, &one, &Entry::one);
    const std::shared_ptr<Maintain> removed = std::move(found->maintain);
    all_.erase(found);
    lock.unlock();
    removed->clear();
  }
  /// Calls each task in turn, without holding the mutex meanwhile. Allocates only if there are more tasks
  /// than ever before. Must be called by the agent's thread.
  void maintain(Time now) {
    {
      const core::Lock lock(mutex_);
      round_ = all_;
    }
    next_ = Time::max();
    for (const Entry& entry : round_) (*entry.maintain)(now, next_);
    round_.clear();
  }
  /// Schedules the next call of maintain() for the time `next` at the latest. Must be called by the agent's
  /// thread.
  void maintain_by(Time next) { next_ = std::min(next_, next); }
  /// Returns the time by which maintain() must be called again; Time::max(): at no certain time. Must be
  /// called by the agent's thread.
  Time next() const { return next_; }

 private:
  using Maintain = core::GuardedCall<Time, Time&>;
  struct Entry {
    const Periodic* one;
    std::shared_ptr<Maintain> maintain;
  };

  core::Mutex mutex_;
  std::vector<Entry> all_ SFT_GUARDED_BY(mutex_);
  std::vector<Entry> round_;  ///< used by the agent's thread, like `next_`
  Time next_ = Time::max();
};

/// The shared state. It lives until the transport and all of its writers are destroyed.
struct SendSide {
  SendSide(std::unique_ptr<DatagramSender> io, const DestinationLimits& to_each,
           std::uint64_t max_bytes_per_s = 0)
      : sender(std::move(io), max_bytes_per_s),
        destinations(to_each, [this](const SocketAddress& to) { return sender.connect(to); }),
        limits(to_each) {}

  Sender sender;
  DestinationDirectory destinations;
  ChannelRegistry channels;
  GroupRegistry groups;
  PeriodicTasks writers;
  DestinationLimits limits;  ///< limits of each destination and of each multicast group
  Multicast multicast = Multicast::automatic;
  // The next two members are used by the agent's thread.
  core::NetworkMonitor network_watch;
  KnownMulticastLinks links{network_watch};
  std::uint16_t answer_port = 0;     ///< our port to which acks and reports are sent
  std::size_t max_sample_bytes = 0;  ///< the maximum size in bytes of a sent body
  std::size_t queue_depth = 0;
  /// The node's own memory; may be null. Samples in any other memory count as borrowed.
  std::shared_ptr<core::BufferPool> pool;
  std::shared_ptr<KeptMemory> kept = std::make_shared<KeptMemory>();
  std::atomic<std::uint64_t> over_limit{0}, malformed_answers{0}, answers_rejected{0};
};

}  // namespace sft::udp
