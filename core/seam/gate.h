// A gate decides which samples of a writer go to the readers that ask for the same conditions and the same
// maximum rate. A gate uses no clock: samples and stamps are passed in, decisions are returned.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/seam/rate_budget.h"
#include "sft/detail/conditions.h"

namespace sft::core {

/// Returns the id of a gate with conditions, or 0 if there are none. Samples contain the ids of the gates
/// that they have passed. `conditions` is the hash of a Selection's gate without a rate, or 0.
std::uint64_t gate_id(std::uint64_t conditions, std::uint32_t min_period_us);

/// The publisher's thread calls the functions of a gate, except for those that say otherwise.
class Gate {
 public:
  /// Makes a gate for a maximum rate without conditions. The gate begins with a budget for one sample, so
  /// that there is no burst. The gates of its readers begin with the same budget.
  explicit Gate(std::uint32_t min_period_us) : budget_(min_period_us, 1) {}
  /// Makes a gate with conditions, which Conditions::check() must have accepted. No sample passes before
  /// reader_begins() was called for the first reader. `hash` is that of the selection's gate without a rate.
  Gate(std::uint32_t min_period_us, detail::Conditions conditions, std::uint64_t hash)
      : budget_(min_period_us, 1),
        conditions_(std::move(conditions)),
        id_(gate_id(hash, min_period_us)),
        is_open_(false) {}

  /// Returns the minimum time between two samples, in microseconds. Any thread may call this.
  std::uint32_t min_period_us() const { return budget_.min_period_us(); }
  /// Returns the id of the gate (gate_id()), or 0 if the gate has no conditions. Any thread may call this.
  std::uint64_t id() const { return id_; }

  /// Decides if a sample passes. Called once for every sample. If the sample passes, made() or refused()
  /// must be called next. If the sample could not be made, neither must be called. Then the readers miss
  /// the sample, and later samples are compared with the sample before it.
  void consider(const detail::FieldSource& sample, std::int64_t stamp_ns) {
    before_ = budget_;
    passes_ = conditions_.empty() ? budget_.take(stamp_ns) : decide(sample, stamp_ns);
    if (passes_) {
      ++ordinal_;
      add(passed_, 1);
    } else {
      add(withheld_, 1);
    }
  }
  /// Called when the sample that passed is sent. Later samples are compared with this sample.
  void made(const detail::FieldSource& sample, std::int64_t stamp_ns) {
    if (passes_ && id_ != 0) conditions_.passed(sample, stamp_ns);
  }
  /// Called instead of made() when the message is refused. Undoes consider(), as if the message had never
  /// been published.
  void refused() {
    if (!passes_) return;
    budget_ = before_;
    --ordinal_;
    add(passed_, -1);
  }
  /// Called when the request of a reader takes effect. The next sample that fulfils the conditions is the
  /// first one for this reader. This sample is not compared with earlier samples, and passes even if it
  /// exceeds the maximum rate. Any thread may call this.
  void reader_begins() noexcept { reader_begins_.store(true, std::memory_order_relaxed); }

  /// Returns true if the sample that was considered last is for the readers of this gate.
  bool passes() const { return passes_; }
  /// Returns the ordinal of the last sample that passed the gate: its number among all samples that passed.
  /// Readers use it to distinguish lost samples from withheld ones.
  std::uint32_t ordinal() const { return ordinal_; }
  // The counts of samples that passed the gate, and of those that it withheld. Any thread may call this.
  std::uint64_t passed() const { return passed_.load(std::memory_order_relaxed); }
  std::uint64_t withheld() const { return withheld_.load(std::memory_order_relaxed); }

 private:
  using Count = std::atomic<std::uint64_t>;

  bool decide(const detail::FieldSource& sample, std::int64_t stamp_ns);
  /// Adds without a locked instruction, because only the publisher's thread writes the count.
  static void add(Count& count, int more) {
    count.store(count.load(std::memory_order_relaxed) + static_cast<std::uint64_t>(more),
                std::memory_order_relaxed);
  }

  RateBudget budget_;
  RateBudget before_;  ///< the budget before the sample that was considered last
  detail::Conditions conditions_;
  std::uint64_t id_ = 0;
  bool is_open_ = true;
  bool passes_ = false;
  std::uint32_t ordinal_ = 0;
  std::atomic<bool> reader_begins_{false};
  Count passed_{0}, withheld_{0};
};

}  // namespace sft::core
