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

/// A task that the agent's thread has to perform now and then.
class Periodic {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Performs the task. Returns when it has to be called again; Time::max() if that is not urgent.
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
  /// Removes a task. When this returns, the task is not called any more, and no call of it is in progress.
  void remove(const Periodic& one) {
    core::Lock lock(mutex_);
    const auto found = std::ranges::find(all_, &one, &Entry::one);
    const std::shared_ptr<Maintain> removed = std::move(found->maintain);
    all_.erase(found);
    lock.unlock();
    removed->clear();
  }
  /// Calls each task in turn, without holding the mutex meanwhile. Allocates nothing while there are no
  /// more tasks than before. Called by the agent's thread.
  void maintain(Time now) {
    {
      const core::Lock lock(mutex_);
      round_ = all_;
    }
    next_ = Time::max();
    for (const Entry& entry : round_) (*entry.maintain)(now, next_);
    round_.clear();
  }
  /// Schedules the next call of maintain() for that time at the latest. Called by the agent's thread.
  void maintain_by(Time next) { next_ = std::min(next_, next); }
  /// Returns when maintain() has to be called again; Time::max() if that is not urgent. Called by the
  /// agent's thread.
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

/// The shared state. It lives as long as the transport, or any of its writers.
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
  DestinationLimits limits;  ///< limits of each destination; each multicast group gets a copy
  Multicast multicast = Multicast::automatic;
  // The next two members are used by the agent's thread.
  core::NetworkMonitor network_watch;
  KnownMulticastLinks links{network_watch};
  std::uint16_t answer_port = 0;     ///< port that acks and reports come to
  std::size_t max_sample_bytes = 0;  ///< the largest body that is sent
  std::size_t queue_depth = 0;
  /// The node's own memory. Samples in any other memory are borrowed. May be null.
  std::shared_ptr<core::BufferPool> pool;
  std::shared_ptr<KeptMemory> kept = std::make_shared<KeptMemory>();
  std::atomic<std::uint64_t> over_limit{0}, malformed_answers{0}, answers_rejected{0};
};

}  // namespace sft::udp
