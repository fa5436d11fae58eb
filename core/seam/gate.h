// The gate of a writer for those of its readers that want the same samples: those that fulfil certain
// conditions, and no more than so many a second. Pure: samples and stamps in, answers out.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "core/seam/rate_budget.h"
#include "sft/detail/conditions.h"

namespace sft::core {

/// Names a gate with conditions, wherever readers tell by it what they were sent. `conditions` is the hash of
/// a Selection's gate without a rate. 0: there are no conditions.
std::uint64_t gate_id(std::uint64_t conditions, std::uint32_t min_period_us);

/// Used by the publisher's thread, except where a function says more.
class Gate {
 public:
  /// A gate for a maximum rate alone. It begins with one sample, not with a burst, and so do its readers.
  explicit Gate(std::uint32_t min_period_us) : budget_(min_period_us, 1) {}
  /// A gate with conditions, which Conditions::check() has accepted. Nothing passes before reader_begins()
  /// was called for its first reader. `hash` is that of the selection's gate without a rate.
  Gate(std::uint32_t min_period_us, detail::Conditions conditions, std::uint64_t hash)
      : budget_(min_period_us, 1),
        conditions_(std::move(conditions)),
        id_(gate_id(hash, min_period_us)),
        is_open_(false) {}

  /// Any thread.
  std::uint32_t min_period_us() const { return budget_.min_period_us(); }
  /// The name of a gate with conditions (gate_id()); 0: it has none. Any thread.
  std::uint64_t id() const { return id_; }

  /// Called once for every sample. A sample that passes is then reported by made() or refused(); if it could
  /// not be made, its readers miss it, and later ones are compared with the one before.
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
  /// The sample that passed is sent: later ones are compared with it.
  void made(const detail::FieldSource& sample, std::int64_t stamp_ns) {
    if (passes_ && id_ != 0) conditions_.passed(sample, stamp_ns);
  }
  /// The message was refused, as if it had never been published.
  void refused() {
    if (!passes_) return;
    budget_ = before_;
    --ordinal_;
    add(passed_, -1);
  }
  /// A request is in force. The next sample that the conditions let pass is its first one, for which nothing
  /// is compared with earlier samples, and the rate is not asked. Any thread.
  void reader_begins() noexcept { reader_begins_.store(true, std::memory_order_relaxed); }

  /// True if the sample that was considered last is for the readers behind this gate.
  bool passes() const { return passes_; }
  /// The number of the last sample that passed. Readers tell by it what was lost from what was withheld.
  std::uint32_t ordinal() const { return ordinal_; }
  // Any thread: how many samples passed, and how many did not.
  std::uint64_t passed() const { return passed_.load(std::memory_order_relaxed); }
  std::uint64_t withheld() const { return withheld_.load(std::memory_order_relaxed); }

 private:
  using Count = std::atomic<std::uint64_t>;

  bool decide(const detail::FieldSource& sample, std::int64_t stamp_ns);
  /// Nobody else writes it.
  static void add(Count& count, int more) {
    count.store(count.load(std::memory_order_relaxed) + static_cast<std::uint64_t>(more),
                std::memory_order_relaxed);
  }

  RateBudget budget_;
  RateBudget before_;  ///< the sample that was considered last
  detail::Conditions conditions_;
  std::uint64_t id_ = 0;
  bool is_open_ = true;
  bool passes_ = false;
  std::uint32_t ordinal_ = 0;
  std::atomic<bool> reader_begins_{false};
  Count passed_{0}, withheld_{0};
};

}  // namespace sft::core
