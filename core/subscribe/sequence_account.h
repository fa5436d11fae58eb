// Counts the samples of one writer that a reader did not get. The count is derived from the samples that it
// did get. A missing sample was lost, or withheld by the conditions or the maximum rate that the reader asked
// for. Uses no clock, thread or I/O.
//
// Over UDP the writer withholds samples, and each sample carries its ordinal: its number among the samples
// that passed the gate. Between two samples of one gate, the difference of the ordinals shows exactly how
// many samples were lost, and the difference of the sequences how many were withheld. This holds whatever
// happened to datagrams and masks meanwhile.
//
// A gate with conditions works in the same way over UDP and in shared memory, where samples carry ordinals,
// too (core/seam/gate_table.h), and the writer puts no other samples into the reader's queue. If other
// conditions can have been in force between two samples, it is unknown how many samples passed them. Then the
// samples that are missing in between count as withheld (asked_gates.h).
//
// In shared memory the writer gives a sample to all readers without conditions, so the reader skips samples
// by itself to keep its maximum rate. The result is the same, because the reader keeps the same budget over
// the same stamps as the writer's gate, by which the writer decides which readers to wake. Samples that the
// queue dropped, or that are missing because the rate or the path was changed, cannot be examined any more.
// The maximum rate entitled the reader to one sample in each period, and one unused sample can be saved.
// Missing samples to which the reader was entitled count as lost if they could not be saved.
// The others count as withheld. If the writer paused in between, too many count as lost, but never too few.
#pragma once

#include <cstdint>
#include <optional>

#include "core/seam/rate_budget.h"
#include "core/seam/sample_origin.h"
#include "core/subscribe/asked_gates.h"

namespace sft::core {

/// The side that applies the maximum rate of a reader. For samples by UDP, which are all for the reader, it
/// is the writer. For samples in shared memory it is the reader itself.
enum class RateKeeper : std::uint8_t { reader, writer };

class SequenceAccount {
 public:
  /// Sets the least time between two samples, by the maximum rate that the reader asks for; 0: none.
  void ask(std::uint32_t min_period_us) { asked_ = min_period_us; }
  /// Sets the number of retained samples of the writer that should arrive first, if the writer has that many.
  void owe(std::uint32_t samples) { owed_ = samples; }

  /// Returns false if the sample, or a later one, was taken already.
  bool is_new(const SampleOrigin& sample) const { return sample.sequence > last_ || begins_anew(sample); }
  /// Begins anew with a sample whose sequence has come already, but whose stamp is later than that of the
  /// last sample: its writer has restarted under its old name. Must be called only for samples that come in
  /// the order of their writer.
  void note_restart(const SampleOrigin& sample) {
    if (sample.sequence <= last_ && sample.source_stamp_ns > stamp_ns_) last_ = sample.sequence - 1;
  }
  /// Notes a sample that is not new. The two paths never differ very much. So if a sample is very far behind
  /// the last one, the sequence of the last one may have been forged. At the second such sample in a row the
  /// account begins anew.
  void refuse(const SampleOrigin& sample) { far_behind_ = is_far_behind(sample) ? sample.sequence : 0; }
  /// Returns true if, according to the numbers, no sample for the reader is missing before this one.
  bool follows(const SampleOrigin& sample, const AskedGates& asked) const {
    return sample.sequence == last_ + 1 || begins_anew(sample) || is_next_of_gate(sample, asked);
  }
  /// Returns true if a new sample is for the reader, and false if it has to be skipped.
  bool allows(const SampleOrigin& sample, RateKeeper keeper) const;

  struct Missing {
    std::uint64_t lost = 0;
    /// The number of withheld samples, including the sample itself if it is skipped.
    std::uint64_t withheld = 0;
  };
  /// Enters a new sample, which is delivered or skipped according to allows(). Returns the numbers of samples
  /// that are missing before it.
  Missing enter(const SampleOrigin& sample, RateKeeper keeper, const AskedGates& asked);

 private:
  /// The largest plausible gap if sequences begin anew, or among retained samples. Larger gaps are ignored.
  static constexpr std::uint64_t gap_max = std::uint64_t{1} << 16;

  bool begins_anew(const SampleOrigin& sample) const {
    return sample.numbering > numbering_ || (is_far_behind(sample) && confirms(sample));
  }
  /// Returns true if conditions have withheld all samples that are missing before this one.
  bool is_next_of_gate(const SampleOrigin& sample, const AskedGates& asked) const {
    return is_of_same_gate(sample) && sample.ordinal == *ordinal_ + 1U &&
           asked.only_gate_since(request_) == sample.gate;
  }
  /// Returns true if this sample and the last one have ordinals of the same gate. Retained samples have no
  /// ordinals, since they passed no gate.
  bool is_of_same_gate(const SampleOrigin& sample) const {
    return sample.gate != 0 && sample.gate == gate_ && ordinal_ && sample.ordinal != 0;
  }
  bool is_far_behind(const SampleOrigin& sample) const {
    return sample.sequence < last_ && last_ - sample.sequence >= gap_max;
  }
  bool confirms(const SampleOrigin& sample) const {
    return far_behind_ != 0 && sample.sequence > far_behind_ && sample.sequence - far_behind_ < gap_max;
  }
  std::uint32_t limit_of(const SampleOrigin& sample, RateKeeper keeper) const {
    return keeper == RateKeeper::writer ? sample.min_period_us : asked_;
  }
  std::uint64_t gap_before(const SampleOrigin& sample) const;
  std::uint64_t lost_before(const SampleOrigin& sample, RateKeeper keeper, const AskedGates& asked,
                            std::uint64_t gap) const;

  std::uint32_t asked_ = 0;
  std::uint32_t owed_ = 0;
  // The values of the sample that was entered last:
  std::uint64_t last_ = 0;  ///< the sequence; 0: there was no sample yet
  std::int64_t stamp_ns_ = 0;
  RateBudget budget_;  ///< the budget of the maximum rate with which the sample arrived
  std::optional<std::uint32_t> ordinal_;
  std::uint64_t gate_ = 0;
  AskedGates::Number request_ = 0;  ///< the earliest request that can have been in force for the sample
  std::uint32_t numbering_ = 0;
  /// The sequence of the last refused sample, if it was far below `last_`; 0: none.
  std::uint64_t far_behind_ = 0;
};

}  // namespace sft::core
