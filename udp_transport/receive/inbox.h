// Passes samples from the receiving thread, which delivers them, to the threads of one reader, which take
// them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/guarded_call.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/receive/keep_last_queue.h"
#include "udp_transport/receive/late_filter.h"

namespace sft::udp {

class Inbox {
 public:
  /// `listener` may be null. ReaderSpec explains `depth` and `depth_bytes`.
  Inbox(std::size_t depth, core::ArrivalListener* listener, std::uint64_t depth_bytes = 0)
      : depth_(depth == 0 ? 1 : depth), depth_bytes_(depth_bytes), notify_listener_([listener] {
          if (listener != nullptr) listener->arrived();
        }) {}

  /// Queues a sample of a connected writer. Then calls the listener, without a lock. Must be called by the
  /// receiving thread.
  void deliver(core::SampleHandle sample) noexcept { deliver(std::span(&sample, 1)); }
  /// Queues several samples. Afterwards, the handles are null or hold samples that were displaced. If not
  /// all of them can wait at a time, the listener is called after each part, so that it can take samples
  /// before later ones displace them.
  void deliver(std::span<core::SampleHandle> samples,
               KeepLastQueue::Excess excess = KeepLastQueue::Excess::pushed_out) noexcept;

  /// Says which further samples of the writer can be queued without displacing older ones. Further samples
  /// are not refused, but displace the oldest ones.
  KeepLastQueue::Room room(core::EndpointId writer) const noexcept;

  core::SampleHandle take() noexcept;

  void connect(const core::Source& source);
  /// Disconnects the writer. Its queued samples can still be taken. All disconnected writers together keep
  /// at most as many samples and bytes as one connected writer: the newest ones.
  void disconnect(core::EndpointId writer) noexcept;
  bool connected(core::EndpointId writer) const noexcept;
  core::HistoryProgress history(core::EndpointId writer) const noexcept;
  std::uint64_t arrivals(core::EndpointId writer) noexcept;
  std::uint64_t discarded() const noexcept;
  std::uint64_t lost_unnoticed() const noexcept;

  /// Ends calls of the listener. When this function returns, no call of the listener is in progress, except
  /// if the listener itself has called this function.
  void detach() noexcept { notify_listener_.clear(); }

 private:
  struct Writer {
    core::EndpointId id;
    KeepLastQueue queue;
    bool connected = true;
    LateFilter filter{};
    bool taken = false;         ///< true if at least one sample of the writer was taken
    std::uint64_t dropped = 0;  ///< number of samples dropped since a sample was last taken
    std::uint64_t arrivals = 0;
  };
  Writer* find(core::EndpointId id) noexcept SFT_REQUIRES(mutex_);
  const Writer* find(core::EndpointId id) const noexcept SFT_REQUIRES(mutex_);
  bool enqueue(core::SampleHandle& sample, KeepLastQueue::Excess excess) noexcept SFT_REQUIRES(mutex_);
  struct Enqueued {
    std::size_t samples = 0;  ///< number of samples handled, counted from the first one
    std::size_t kept = 0;     ///< number of these samples that were kept
  };
  Enqueued enqueue_some(std::span<core::SampleHandle> samples, KeepLastQueue::Excess excess) noexcept
      SFT_REQUIRES(mutex_);
  /// Returns the writer whose oldest waiting sample came first, of the writers for which `condition` is
  /// true.
  template <class Condition>
  Writer* first_to_come(Condition condition) noexcept SFT_REQUIRES(mutex_);
  core::SampleHandle drop_surplus() noexcept;
  void forget_the_finished() noexcept SFT_REQUIRES(mutex_);

  const std::size_t depth_;
  const std::uint64_t depth_bytes_;
  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  std::vector<Writer> writers_ SFT_GUARDED_BY(mutex_);
  std::uint64_t arrivals_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t discarded_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t lost_unnoticed_ SFT_GUARDED_BY(mutex_) = 0;
  core::GuardedCall<> notify_listener_;  ///< called without the mutex
};

}  // namespace sft::udp
