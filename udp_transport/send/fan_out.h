// Sends the samples of one writer on the sending thread, for all masks except the first few. So many masks
// do not delay the publisher's thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "core/seam/sample_buffer.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/deferred_work.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {

class FanOut final : public DeferredWork {
 public:
  FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side, std::shared_ptr<WriterTally> tally,
         std::shared_ptr<JobPool> jobs);

  /// A sample, and the audiences to which it still has to be sent: the audiences without a gate whose
  /// indices are in [first, end).
  struct DeferredSample {
    core::SampleHandle sample;
    std::shared_ptr<const RouteTable> routes;
    std::size_t first = 0;
    std::size_t end = 0;
  };

  // The following functions are for the publisher's thread.

  /// Returns true if no deferred sample is left, so that a sample that is sent now overtakes no other.
  bool done() const { return done_.load(std::memory_order_acquire); }
  /// Returns true if the sending thread sends large samples with all masks (PublisherOptions::asynchronous).
  bool takes_large() const { return takes_large_; }

  struct Posted {
    Wake wake = Wake::none;
    std::size_t dropped = 0;  ///< number of older samples that were dropped because too many waited
  };
  Posted post(DeferredSample deferred) noexcept;

  /// Waits until no deferred sample is left, or the sending thread has stopped. After that, the writer's
  /// type may be destroyed.
  void finish() noexcept;

  /// Sends a part of the deferred samples. Called by the sending thread.
  bool carry_out() noexcept override;

 private:
  static bool is_large(const DeferredSample& deferred) {
    return deferred.sample->capacity > direct_bytes_max;
  }
  std::optional<DeferredSample> take_surplus_before(const DeferredSample& newcomer) noexcept;
  /// Removes and returns the oldest sample. REQUIRES: the queue is not empty.
  DeferredSample pop_oldest() noexcept SFT_REQUIRES(mutex_);
  std::optional<DeferredSample> take() noexcept;
  static std::span<const Audience> audiences_of(const DeferredSample& deferred) {
    return std::span(deferred.routes->audiences).subspan(deferred.first, deferred.end - deferred.first);
  }
  static bool is_reliable(const DeferredSample& deferred);
  static void count_dropped(const DeferredSample& deferred) noexcept;

  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  const bool takes_large_;
  std::atomic<bool> done_{true};
  core::Mutex mutex_;
  OrdinalRing<DeferredSample> queue_ SFT_GUARDED_BY(mutex_){1};  ///< the oldest sample is first
  std::size_t queued_bytes_ SFT_GUARDED_BY(mutex_) = 0;          ///< memory of the queued samples, in bytes
  VariantSender sender_;                                         ///< used by the sending thread
};

}  // namespace sft::udp
