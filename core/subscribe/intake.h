// The order in which a subscriber takes the samples that its two paths bring for one of its selections, and
// which samples it takes at all. Pure: samples, answers and the time go in, decisions come out; it knows no
// port, no clock and no lock. Not safe for threads: subscriber_ports.h guards it.
//
// - The samples of one writer are delivered by rising sequence, whichever path brings them. Between writers
//   the sample with the older stamp goes first.
// - Shared memory can be behind UDP: a sample that came by UDP lets earlier samples of its writer go first,
//   even if they lie in shared memory behind samples of other writers.
// - UDP can be behind shared memory: samples that do not fit into it are diverted. A sample in shared memory
//   names the last one that its writer has diverted, and waits for it, but not longer than `timeout`.
// - Each sample is delivered once, also if both paths bring it.
// - A sample that has expired is dropped, as is one that the maximum rate of the subscriber does not allow.
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

/// A sample that is taken, and what its subscriber is told of it.
struct Taken {
  SampleHandle sample;
  SampleInfo info;
};

/// True if a sample is to be delivered before another one that has come, too.
inline bool goes_first(const SampleOrigin& a, const SampleOrigin& b) {
  return a.writer == b.writer ? a.sequence < b.sequence : a.source_stamp_ns < b.source_stamp_ns;
}

class Intake {
 public:
  struct Options {
    std::chrono::nanoseconds timeout{0};  ///< for a diverted sample, from when that was published
    std::uint32_t min_period_us = 0;      ///< of the maximum rate; 0: none
    std::size_t slots = 0;                ///< of the message type
  };

  /// Where samples lie until it is their turn, each inlet with one sample. `overtaken`: a sample that was
  /// taken from the middle of shared memory, because UDP is ahead of it.
  enum class Inlet : std::uint8_t { memory, network, overtaken };

  enum class Decision : std::uint8_t {
    deliver,        ///< take() returns the next sample
    nothing,        ///< no sample can be delivered at present
    dropped,        ///< a sample was dropped: fill the inlets, and call next() again
    ask_connected,  ///< answer with connected()
    ask_overtaken,  ///< answer with overtaken()
  };

  explicit Intake(const Options& options) : options_(options), accounts_(options.min_period_us) {}

  /// The inlets `memory` and `network` are filled before next() is called, as far as there are samples.
  bool is_empty(Inlet inlet) const { return !head(inlet); }
  bool is_empty() const { return !heads_[0] && !heads_[1] && !heads_[2]; }
  void put(Inlet inlet, SampleHandle sample);

  /// Decides about the next sample.
  Decision next(LazyRealtime& now);
  /// The writer that a decision asks about.
  EndpointId asked_about() const { return asked_about_; }
  /// True if samples of asked_about() can still come by UDP. Returns the next decision.
  Decision connected(bool is_connected, LazyRealtime& now);
  /// The first sample of asked_about() that lies in shared memory; empty if there is none. Returns the next
  /// decision.
  Decision overtaken(SampleHandle found, LazyRealtime& now);

  /// The origin of the sample that was just decided to be delivered.
  const SampleOrigin& next_origin() const { return *head(chosen_); }
  /// The sample that was just decided to be delivered, which is thereby taken.
  Taken take();
  /// Samples from there are copied from now on before they are delivered: they count as received by copied(),
  /// not by take().
  void copy(bool from_memory, bool from_network) {
    copies_from_memory_ = from_memory;
    copies_from_network_ = from_network;
  }
  bool is_copied(TransportKind transport) const {
    return transport == TransportKind::udp ? copies_from_network_ : copies_from_memory_;
  }
  /// A copy of a sample was delivered instead of it, or could not be made: then the sample is lost.
  void copied(const SampleInfo& info, bool is_delivered);
  /// Keeps the newer one of two samples that were taken one after the other; the other one is passed over.
  void keep_newer(Taken& latest, Taken other);
  /// Lets the sample report the losses that samples of its writer would have reported that were passed over.
  void report_losses(Taken& latest);

  /// True if some sample was held back since this was called last.
  bool take_held_back() { return std::exchange(holds_back_, false); }

  WriterAccounts& accounts() { return accounts_; }
  const WriterAccounts& accounts() const { return accounts_; }

 private:
  using Writer = WriterAccounts::Writer;

  SampleHandle& head(Inlet inlet) { return heads_[static_cast<std::size_t>(inlet)]; }
  const SampleHandle& head(Inlet inlet) const { return heads_[static_cast<std::size_t>(inlet)]; }
  bool has_of(Inlet inlet, EndpointId writer) const;
  std::optional<Inlet> oldest() const;
  bool follows(Inlet inlet);
  bool may_wait(LazyRealtime& now);
  Decision let_overtaken_go_first(LazyRealtime& now);
  Decision choose_in_turn(LazyRealtime& now);
  Decision choose(Inlet inlet, LazyRealtime& now);
  static bool is_expired(const Writer& from, const SampleOrigin& sample, LazyRealtime& now);
  static TransportKind transport_of(Inlet inlet);
  RateKeeper rate_keeper_of(Inlet inlet) const;

  const Options options_;
  bool copies_from_memory_ = false;
  bool copies_from_network_ = false;
  std::array<SampleHandle, 3> heads_;  ///< by Inlet
  WriterAccounts accounts_;
  Inlet chosen_{};  ///< what the latest decision is about
  EndpointId asked_about_ = 0;
  bool holds_back_ = false;
};

}  // namespace sft::core
