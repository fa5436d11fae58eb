// Sends the samples of one publisher to its readers: by shared memory, over the network, or by both.
// Samples that shared memory does not take are sent over the network to the readers that have a fallback
// route.
//
// The agent puts outlets (outlets.h) in force by serve(), and the publisher's thread sends samples by them.
// A route must never ask for more fields than a sample has. Therefore the publisher's thread does all its
// work within a Call. When the agent replaces the outlets, it can wait for the end of a Call that has begun
// with the previous outlets.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
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
  /// The type, the book and the ports that a Dispatch uses. All of them must outlive it.
  struct Setup {
    const TypeSupport* type = nullptr;
    std::shared_ptr<NetworkWriter> network;  ///< null if the publisher must not use the network
    std::shared_ptr<DeliveryBook> book;
    History* history = nullptr;  ///< the history that keeps every sample; null if the publisher retains none
    bool waits = false;          ///< true: the publisher waits for readers
    std::string topic{};         ///< the topic, for messages to people
  };
  explicit Dispatch(Setup setup);

  // The functions for the publisher's thread.

  /// Marks one call of the program. The outlets that were in force at the beginning stay in use until the
  /// end of the scope. If a Call begins on a second thread meanwhile, the process is ended.
  class Call {
   public:
    explicit Call(Dispatch& dispatch) : reading_(dispatch.outlets_), dispatch_(dispatch) {
      if (!reading_.is_only()) [[unlikely]]
        dispatch.stop_second_thread();
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
    /// Returns the outlets in force. Sending a sample may put other outlets in force.
    const Outlets& outlets() const noexcept { return *dispatch_.in_force_; }

   private:
    Published<Outlets>::Reading reading_;
    const Dispatch& dispatch_;
    /// The port whose threads leave the processor to this Call; null: none.
    NetworkWriter* yielding_ = nullptr;
  };

  /// The decision of the gates on one sample.
  struct Admission {
    bool passes = false;  ///< at least one reader, or the history, takes the sample
    /// The transmission of the sample; empty: the sample does not use the network.
    std::optional<Transmission> transmission;
  };

  // The following functions must be called within a Call.

  /// Asks each gate once whether the sample passes, before the sample is encoded. If the publisher is
  /// durable, every sample is encoded and no transmission begins here: the sample is first put into the
  /// history, and then sent by the routes that are in force after that (see LateReaders).
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
  /// Called when the admitted message has been encoded. The conditions of readers compare later messages
  /// with this message.
  void made(const detail::FieldSource& sample, std::int64_t stamp_ns) noexcept {
    for (const auto& gate : in_force_->gates) gate->made(sample, stamp_ns);
  }
  /// Called when the admitted message is not published after all.
  void refuse() noexcept {
    for (const auto& gate : in_force_->gates) gate->refused();
  }
  /// Asks each gate whether a sample that is encoded already passes. The handle is empty if there was no
  /// memory for the sample.
  Admission admit(const SampleHandle& sample, std::int64_t stamp_ns) noexcept;
  /// Returns true if copies of parts of the sample may be postponed. This is so if only the network gets the
  /// sample, and the port of the network allows it.
  bool may_postpone() const noexcept {
    return postpones_ && in_force_->to_network && !in_force_->to_memory && in_force_->vanilla == nullptr;
  }
  /// Gives sequences to samples that no reader wants. By the gap in the sequences readers later see that
  /// samples were withheld.
  PublishStatus withhold(std::size_t samples = 1) noexcept {
    sequence_.fetch_add(samples, std::memory_order_relaxed);
    return PublishStatus::ok;
  }
  /// Gives a sequence to a sample that could not be made, and counts the sample as dropped. By the gap in
  /// the sequences readers see that a sample is missing.
  PublishStatus miss(Admission&& admission, std::uint32_t body_bytes) noexcept;
  /// Sends a sample that has all fields, or the fields that the outlets need. Waits for readers for at most
  /// `timeout`, and subtracts the time that it waited from `timeout`.
  PublishStatus send(const SampleHandle& sample, std::int64_t stamp_ns, Admission&& admission,
                     std::chrono::nanoseconds& timeout) noexcept;

  /// Begins a batch. Returns nothing if the publisher does not use the network.
  std::optional<Batch> batch(BatchTimeout timeout) noexcept;
  /// Counts samples that a port has accepted but has not sent.
  void count_dropped(std::size_t samples) noexcept { dropped_.fetch_add(samples, std::memory_order_relaxed); }

  // The functions for the agent's thread.

  /// Gives the routes their gates, and puts the routes of all ports in force. `memory` is null while there
  /// is no shared memory, and `vanilla` while no unmodified DDS reader is served. Returns the fields that
  /// samples have from now on.
  FieldMask serve(Serving& serving, std::shared_ptr<LendingWriter> memory,
                  std::shared_ptr<VanillaPort> vanilla = nullptr);

  // The functions for any thread.

  std::uint64_t published() const noexcept { return sequence_.load(std::memory_order_relaxed); }
  /// Returns the number of samples that were not sent by all of their routes, as far as send() has reported
  /// this at once.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  PublisherStatus::Diverted diverted() const noexcept;

 private:
  [[noreturn, gnu::cold]] void stop_second_thread() const noexcept;
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
  /// Remembers a sample that is sent over the network only. Such a sample takes longer than one in shared
  /// memory. So later samples in shared memory contain its sequence, and readers can wait for this sample.
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
  const std::string topic_;

  Published<Outlets> outlets_;
  std::atomic<std::uint64_t> sequence_{0};
  std::atomic<std::uint64_t> dropped_{0};
  /// The counts of PublisherStatus::Diverted. Only one thread at a time writes them.
  struct Refusals {
    std::atomic<std::uint64_t> exhausted{0}, too_large{0}, unavailable{0}, too_large_bytes{0}, chunk_bytes{0};
  } refusals_;

  // The members for the publisher's thread.
  const Outlets* in_force_ = nullptr;    ///< the outlets by which samples are sent, and for whose page
                                         ///< deliveries are counted
  std::uint64_t diverted_sequence_ = 0;  ///< the sequence of the last sample sent over the network only
  std::int64_t diverted_stamp_ns_ = 0;   ///< the time when that sample was published

  // The members for the agent's thread.
  Gates gates_;
  std::vector<Route> in_memory_, over_network_;  ///< the routes in force
};

}  // namespace sft::core
