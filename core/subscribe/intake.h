// Decides in which order a subscriber takes the samples that arrive by several paths for one of its
// selections, and which of them it drops. Uses no port, clock or lock: samples, answers and the time are
// passed in, decisions are returned. Not thread-safe: the mutex of SubscriberPorts protects it.
//
// - The samples of one writer are delivered in the order of their sequences, whichever path they took. If
//   samples are of different writers, the one with the older stamp is delivered first. But the clocks of
//   writers may differ by any time, so a sample lets only a limited number of samples go first.
// - Shared memory can be slower than UDP. Before a sample that came by UDP, earlier samples of its writer are
//   delivered, even if they lie in shared memory behind samples of other writers.
// - UDP can be slower than shared memory. Samples that shared memory cannot take are diverted to UDP. A
//   sample in shared memory names the last sample that its writer has diverted, and waits at most `timeout`
//   until that sample has arrived. Samples of other writers do not wait with it.
// - Each sample is delivered once, even if it arrives by both paths.
// - Samples of unmodified DDS writers arrive by one path only, and never wait for other samples of their
//   writer.
// - A sample is dropped if it has expired, or if the maximum rate of the subscriber does not allow it.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/platform/clock.h"
#include "core/seam/sample_buffer.h"
#include "core/subscribe/writer_accounts.h"
#include "sft/detail/untyped.h"

namespace sft::core {

/// A sample that is taken, and its information for the program.
struct Taken {
  SampleHandle sample;
  SampleInfo info;
};

/// Returns true if sample `a` has to be delivered before sample `b`. Both samples have arrived.
inline bool goes_first(const SampleOrigin& a, const SampleOrigin& b) {
  return a.writer == b.writer ? a.sequence < b.sequence : a.source_stamp_ns < b.source_stamp_ns;
}

/// The maximum number of samples of other writers that are delivered before a sample that has arrived,
/// because their stamps are older. Without this limit, a writer whose clock is an hour ahead would not be
/// heard for an hour beside one that always has a next sample.
inline constexpr std::uint32_t passed_over_max = 16;

class Intake {
 public:
  struct Options {
    /// The longest time after its publication for which a diverted sample is waited for.
    std::chrono::nanoseconds timeout{0};
    /// The least time between two samples at the maximum rate; 0: no maximum rate.
    std::uint32_t min_period_us = 0;
    std::size_t slots = 0;  ///< the number of index slots of the message type
  };

  /// The places for the next samples, one for each path, and `overtaken` for a sample that was taken from the
  /// middle of the queue in shared memory, because a later sample has arrived by UDP.
  enum class Inlet : std::uint8_t { memory, network, overtaken, vanilla };

  enum class Decision : std::uint8_t {
    deliver,        ///< take() returns the next sample
    nothing,        ///< no sample can be delivered at present
    dropped,        ///< a sample was dropped: fill the inlets, and call next() again
    ask_connected,  ///< the caller must answer with connected()
    ask_overtaken,  ///< the caller must answer with overtaken()
  };

  explicit Intake(const Options& options) : options_(options), accounts_(options.min_period_us) {}

  // The caller fills all inlets but `overtaken`, if there are samples, before it calls next().
  bool is_empty(Inlet inlet) const { return !head(inlet); }
  bool is_empty() const { return !heads_[0] && !heads_[1] && !heads_[2] && !heads_[3]; }
  void put(Inlet inlet, SampleHandle sample);

  /// Decides what happens to the next sample.
  Decision next(LazyRealtime& now);
  /// Returns the writer that the last decision asks about.
  EndpointId asked_about() const { return asked_about_; }
  /// Answers if samples of asked_about() can still arrive by UDP. Returns the next decision.
  Decision connected(bool is_connected, LazyRealtime& now);
  /// Answers with the first sample of asked_about() in shared memory. The handle is empty if there is none.
  /// Returns the next decision.
  Decision overtaken(SampleHandle found, LazyRealtime& now);

  /// Returns the origin of the sample for which the last decision was `deliver`.
  const SampleOrigin& next_origin() const { return *head(chosen_); }
  /// Takes the sample for which the last decision was `deliver`.
  Taken take();
  /// Sets the paths whose samples are copied before they are delivered. Such samples count as received in
  /// copied() instead of take(). Samples of DDS writers are treated as those in shared memory.
  void copy(bool from_memory, bool from_network) {
    copies_from_memory_ = from_memory;
    copies_from_network_ = from_network;
  }
  bool is_copied(TransportKind transport) const {
    return transport == TransportKind::udp ? copies_from_network_ : copies_from_memory_;
  }
  /// Called when a copy of a sample was delivered, or could not be made. In the latter case the sample counts
  /// as lost.
  void copied(const SampleInfo& info, bool is_delivered);
  /// Keeps the newer one of two samples that were taken one after the other, in `latest`. The older one is
  /// skipped.
  void keep_newer(Taken& latest, Taken other);
  /// Adds the losses before skipped samples of the writer to the losses that `latest` reports.
  void report_losses(Taken& latest);

  /// Returns true if a sample was held back since the last call.
  bool take_held_back() { return std::exchange(holds_back_, false); }

  WriterAccounts& accounts() { return accounts_; }
  const WriterAccounts& accounts() const { return accounts_; }

 private:
  using Writer = WriterAccounts::Writer;

  SampleHandle& head(Inlet inlet) { return heads_[static_cast<std::size_t>(inlet)]; }
  const SampleHandle& head(Inlet inlet) const { return heads_[static_cast<std::size_t>(inlet)]; }
  bool has_of(Inlet inlet, EndpointId writer) const;
  bool may_go_first(Inlet inlet) const;
  std::optional<Inlet> first_in_turn() const;
  bool may_wait(LazyRealtime& now);
  Decision decide_in_turn(LazyRealtime& now);
  Decision let_overtaken_go_first(LazyRealtime& now);
  Decision choose_in_turn(LazyRealtime& now);
  Decision choose(Inlet inlet, LazyRealtime& now);
  static bool is_expired(const Writer& from, const SampleOrigin& sample, LazyRealtime& now);
  RateKeeper rate_keeper_of(Inlet inlet) const;

  const Options options_;
  bool copies_from_memory_ = false;
  bool copies_from_network_ = false;
  std::array<SampleHandle, 4> heads_;  ///< the sample in each Inlet
  /// For each Inlet, the number of samples that were delivered from others while its sample waited.
  std::array<std::uint32_t, 4> passed_over_{};
  std::array<bool, 4> waits_{};  ///< for each Inlet, whether this decision has found that its sample waits
  WriterAccounts accounts_;
  Inlet chosen_{};  ///< the inlet of the sample to which the latest decision applies
  EndpointId asked_about_ = 0;
  bool holds_back_ = false;
};

}  // namespace sft::core
