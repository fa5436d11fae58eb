// The samples of one writer that its publisher's thread has left, from some mask on, to the sending thread:
// so it takes that thread no longer however many masks there are.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "core/seam/sample_buffer.h"
#include "core/seam/transport.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {

class FanOut final : public LeftWork {
 public:
  FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side, std::shared_ptr<WriterTally> tally,
         std::shared_ptr<JobPool> jobs);

  struct Rest {
    core::SampleHandle sample;
    std::shared_ptr<const RouteTable> routes;
    std::size_t first = 0;  ///< of the groups that are left, those without a gate
    std::size_t end = 0;
  };

  // The publisher's thread.

  /// Nothing is left: what is sent now overtakes nothing.
  bool done() const { return done_.load(std::memory_order_acquire); }

  struct Posted {
    bool was_idle = false;        ///< the sending thread has to be told
    bool dropped_oldest = false;  ///< there were too many
  };
  Posted post(Rest rest) noexcept;

  /// Waits until nothing is left, unless it will not be sent any more: the writer's type may go then.
  void finish() noexcept;

  /// The sending thread.
  void carry_out() noexcept override;

 private:
  static bool is_large(const Rest& rest) { return rest.sample->capacity > direct_bytes_max; }
  std::optional<Rest> take_surplus_before(const Rest& newcomer) noexcept;
  Rest pop_oldest() noexcept;
  std::optional<Rest> take() noexcept;
  static std::span<const Group> of(const Rest& rest) {
    return std::span(rest.routes->groups).subspan(rest.first, rest.end - rest.first);
  }
  static bool is_reliable(const Rest& rest);
  static void count_dropped(const Rest& rest) noexcept;

  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  std::atomic<bool> done_{true};
  std::mutex mutex_;
  OrdinalRing<Rest> queue_{1};    ///< the oldest first
  std::size_t queued_bytes_ = 0;  ///< of memory that these hold
  VariantSender sender_;          ///< of the sending thread
};

}  // namespace sft::udp
