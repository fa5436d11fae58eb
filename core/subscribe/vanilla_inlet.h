// The samples that come to one selection of a subscriber from unmodified DDS writers. These send whole
// messages to everybody, so the conditions and the maximum rate of the selection are applied here, by the
// same gates by which writers of SFT apply them.
//
// Threads that receive call put(). Any thread may call the other functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/seam/gate.h"
#include "core/seam/reader_port.h"
#include "core/seam/sample_buffer.h"
#include "core/seam/vanilla_port.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::core {

class VanillaInlet {
 public:
  /// The most writers that have samples here. Samples of further ones are discarded.
  static constexpr std::size_t writers_max = 1024;

  /// `type` outlives the inlet and all its samples. For each writer at most `depth` samples wait to be taken,
  /// and at most `depth_bytes`, but at least one; 0: no limit of the bytes.
  VanillaInlet(const TypeSupport& type, std::uint32_t depth, std::uint64_t depth_bytes);
  ~VanillaInlet();

  /// Returns true if there is one more sample to be taken.
  bool put(const VanillaArrival& arrival);

  /// Returns the sample that came first, of all writers; empty if there is none.
  SampleHandle take();
  /// Sets which samples the selection asks for. Samples that have come already can be taken nevertheless.
  void ask(const Selection& selection, std::uint32_t min_period_us);
  /// Forgets the other writers, which have gone, once their samples were taken. Of all of them together at
  /// most as many samples and bytes wait as of one writer: the newest ones.
  void forget_others_than(std::span<const EndpointId> writers);
  /// Returns a number that changes whenever a sample of that writer arrives.
  std::uint64_t arrivals(EndpointId writer) const;
  /// Returns the number of samples of that writer that were discarded before its first one was taken.
  std::uint64_t lost_before_first(EndpointId writer) const;
  ReaderPort::Counters counters() const;

 private:
  class Lender;
  struct Waiting {
    SampleHandle sample;
    std::uint64_t arrival = 0;           ///< its number among the samples of all writers
    std::uint64_t discarded_before = 0;  ///< samples between it and the one before it that could not be read
  };
  struct Writer {
    std::unique_ptr<Gate> gate{};  ///< null: all samples are asked for
    std::deque<Waiting> waiting{};
    std::uint64_t bytes = 0;         ///< the bytes of the bodies that wait
    std::uint64_t last = 0;          ///< the sequence of the last sample that arrived; 0: there was none
    std::int64_t last_stamp_ns = 0;  ///< the stamp of that sample; 0: its writer gave none
    std::uint64_t arrivals = 0;
    std::uint64_t discarded = 0;         ///< since the last sample was taken, before the first one that waits
    std::uint64_t discarded_behind = 0;  ///< after the last sample that waits
    std::uint64_t lost_before_first = 0;  ///< the value of `discarded` when the first sample was taken
    bool was_taken = false;
    bool is_gone = false;  ///< it was not among the writers of the last forget_others_than()
    /// Samples that are missing between those that arrived. It is not known if the gate had let them pass, so
    /// they count as lost: the ordinals of the gate go on by as many.
    std::uint32_t missing = 0;

    /// Returns how many samples were discarded before the first one that waits now, and forgets it.
    std::uint64_t take_discarded_before_next() {
      return std::exchange(waiting.empty() ? discarded_behind : waiting.front().discarded_before, 0);
    }
  };

  Writer* writer_of(EndpointId id) SFT_REQUIRES(mutex_);
  std::unique_ptr<Gate> make_gate() const SFT_REQUIRES(mutex_);
  static bool passes(Writer& writer, SampleBuffer& sample, std::size_t slots);
  void enqueue(Writer& writer, SampleHandle sample) SFT_REQUIRES(mutex_);
  void discard_oldest(Writer& writer) SFT_REQUIRES(mutex_);
  void discard_surplus(std::span<Writer* const> gone) SFT_REQUIRES(mutex_);
  bool are_too_many(std::size_t samples, std::uint64_t bytes) const {
    return samples > 1 && (samples > depth_ || (depth_bytes_ != 0 && bytes > depth_bytes_));
  }

  const TypeSupport& type_;
  const std::uint32_t depth_;
  const std::uint64_t depth_bytes_;
  const std::shared_ptr<Lender> lender_;
  mutable Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoint) SFT_ACQUIRED_BEFORE(lock_order::facts);
  std::map<EndpointId, Writer> writers_ SFT_GUARDED_BY(mutex_);
  Selection asked_ SFT_GUARDED_BY(mutex_);
  std::uint32_t min_period_us_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t arrivals_ SFT_GUARDED_BY(mutex_) = 0;
  ReaderPort::Counters counters_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
