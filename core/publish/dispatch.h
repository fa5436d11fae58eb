// Sends the samples of one publisher to where its readers are: by shared memory, over the network, or by
// both; and what shared memory does not take, over the network to the readers that have a fallback route.
//
// The agent puts outlets in force (serve()), and the publisher's thread sends by them. No route may ever ask
// for more than a sample has. Therefore the publisher's thread does everything within a Call, and whoever
// replaces the outlets may wait for the Call that began with the ones before.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/publish/gates.h"
#include "core/publish/history.h"
#include "core/publish/outlets.h"
#include "core/seam/delivery.h"
#include "core/seam/writer_port.h"
#include "core/sync/published.h"
#include "sft/detail/conditions.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/untyped.h"

namespace sft::core {

class Dispatch {
 public:
  /// The type, the book and the ports that the dispatch works with. All of them outlive the dispatch.
  struct Setup {
    const TypeSupport* type = nullptr;
    std::shared_ptr<NetworkWriter> network;  ///< null if the publisher must not use it
    std::shared_ptr<DeliveryBook> book;
    History* history = nullptr;  ///< keeps every sample; null if the publisher retains none
    bool waits = false;          ///< the publisher waits for readers
  };
  explicit Dispatch(Setup setup);

  // The publisher's thread.

  /// The outlets that are in force for one call of the program, from the beginning to the end of the scope.
  class Call {
   public:
    explicit Call(Dispatch& dispatch) : reading_(dispatch.outlets_), dispatch_(dispatch) {
      dispatch.look_at_outlets();
      if (!outlets().to_memory || dispatch.network_ == nullptr) return;
      yielding_ = dispatch.network_.get();
      yielding_->begin_local_turn();
    }
    ~Call() {
      if (yielding_ != nullptr) yielding_->end_local_turn();
    }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;
    /// The outlets in force. Sending a sample may replace them.
    const Outlets& outlets() const noexcept { return *dispatch_.in_force_; }

   private:
    Published<Outlets>::Reading reading_;
    const Dispatch& dispatch_;
    NetworkWriter* yielding_ = nullptr;  ///< the port that makes way meanwhile; null: none
  };

  /// The verdict of the gates on one sample.
  struct Admission {
    bool passes = false;                       ///< the sample is for somebody
    std::optional<Transmission> transmission;  ///< of the sample; empty if it does not use the network
  };

  // Within a Call.

  /// Asks each gate once about the sample, before it is encoded. (A durable publisher makes every sample, and
  /// sends it by the routes that are in force once the sample is in the history, see serve(): its
  /// transmissions begin then.)
  Admission admit(const detail::FieldSource& sample, std::int64_t stamp_ns) noexcept {
    const Outlets& outlets = *in_force_;
    Admission admission;
    if ((outlets.to_network || outlets.has_fallback) && history_ == nullptr)
      admission.transmission.emplace(network_->begin());
    admission.passes = outlets.to_all || outlets.gates.empty() || history_ != nullptr;
    for (const auto& gate : outlets.gates) {
      gate->consider(sample, stamp_ns);
      admission.passes |= gate->passes();
    }
    return admission;
  }
  /// The message that was admitted has been encoded: later ones are compared with it.
  void made(const detail::FieldSource& sample, std::int64_t stamp_ns) noexcept {
    for (const auto& gate : in_force_->gates) gate->made(sample, stamp_ns);
  }
  /// The message that was admitted is not published after all.
  void refuse() noexcept {
    for (const auto& gate : in_force_->gates) gate->refused();
  }
  /// Admits a sample that is encoded already; empty: there was no memory for it.
  Admission admit(const SampleHandle& sample, std::int64_t stamp_ns) noexcept;
  /// True if nobody but the network gets the sample, which takes copies that are postponed.
  bool may_postpone() const noexcept {
    return postpones_ && in_force_->to_network && !in_force_->to_memory && in_force_->vanilla == nullptr;
  }
  /// Counts samples that nobody wants, so that readers can tell.
  PublishStatus withhold(std::size_t samples = 1) noexcept {
    sequence_.fetch_add(samples, std::memory_order_relaxed);
    return PublishStatus::ok;
  }
  /// Counts a sample that could not be made, so that readers see that one is missing.
  PublishStatus miss(Admission&& admission, std::uint32_t body_bytes) noexcept;
  /// Sends a whole sample, or one that the outlets asked for. Waits for readers for at most `timeout`, and
  /// subtracts the time that it waited from it.
  PublishStatus send(const SampleHandle& sample, std::int64_t stamp_ns, Admission&& admission,
                     std::chrono::nanoseconds& timeout) noexcept;

  /// Returns nothing if the publisher does not use the network.
  std::optional<Batch> batch(BatchTimeout timeout) noexcept;
  /// Counts samples that were handed over and were not sent after all.
  void count_dropped(std::size_t samples) noexcept { dropped_.fetch_add(samples, std::memory_order_relaxed); }

  // The agent's thread.

  /// Gives the routes their gates, and puts a new division of readers between the ports in force. `memory` is
  /// null while there is no shared memory, and `vanilla` while no unmodified DDS reader is served. Returns
  /// what samples have from now on.
  FieldMask serve(Serving& serving, std::shared_ptr<LendingWriter> memory,
                  std::shared_ptr<VanillaPort> vanilla = nullptr);

  // Any thread.

  std::uint64_t published() const noexcept { return sequence_.load(std::memory_order_relaxed); }
  /// Samples that did not get to each route, as far as that was known when they were sent.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  PublisherStatus::Diverted diverted() const noexcept;

 private:
  void look_at_outlets() noexcept {
    const Outlets* outlets = outlets_.load();
    if (outlets != in_force_) [[unlikely]]
      turn_to(*outlets);
  }
  void turn_to(const Outlets& outlets) noexcept;
  SendStatus send_to_memory(const SampleHandle& sample, std::chrono::nanoseconds& timeout) noexcept;
  SendStatus send_over_network(const SampleHandle& sample, Reach reach,
                               std::optional<Transmission>& begun) noexcept {
    if (begun) [[likely]]
      return (*std::move(begun)).send(sample, reach);
    return reach == Reach::usual_routes ? network_->send(sample) : network_->begin().send(sample, reach);
  }
  PublishStatus divert(const SampleBuffer& sample) noexcept;
  /// Samples in shared memory that come later tell their readers that they may have to wait for this one,
  /// which is under way for longer.
  void note_sent_over_network_alone(const SampleBuffer& sample) noexcept {
    diverted_sequence_ = sample.sequence;
    diverted_stamp_ns_ = sample.source_stamp_ns;
  }
  void count_refusal(std::uint32_t body_bytes) noexcept;
  void send_by_both(const Outlets& before, const Outlets& after);

  const TypeSupport& type_;
  const std::shared_ptr<NetworkWriter> network_;
  const std::shared_ptr<DeliveryBook> book_;
  History* const history_;
  const bool waits_;
  const bool postpones_;

  Published<Outlets> outlets_;
  std::atomic<std::uint64_t> sequence_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::uint64_t> exhausted_{0};
  std::atomic<std::uint64_t> too_large_{0};
  std::atomic<std::uint64_t> unavailable_{0};

  // The publisher's thread.
  const Outlets* in_force_ = nullptr;    ///< deliveries are counted on their page
  std::uint64_t diverted_sequence_ = 0;  ///< of the last sample sent over the network alone
  std::int64_t diverted_stamp_ns_ = 0;   ///< when that was published

  // The agent's thread.
  Gates gates_;
  std::vector<Route> in_memory_, over_network_;  ///< the routes in force
};

}  // namespace sft::core
