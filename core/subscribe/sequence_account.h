// Counts the samples of one writer that a reader did not get, by the samples that it did get: they were lost,
// or withheld by the conditions or by the maximum rate that the reader asked for. Pure.
//
// Over UDP the writer withholds samples, and each sample carries its number among the samples that passed the
// gate. Between two samples of one gate the difference of these numbers tells exactly what was lost, and the
// difference of the sequences what was withheld, whatever happened to datagrams and masks meanwhile.
//
// A gate with conditions works in the same way over UDP and in shared memory, where samples carry such
// numbers, too (core/seam/gate_table.h), and the writer puts no others into the reader's queue. Nobody can
// tell by conditions how many samples passed. So where other conditions can have been in force between two
// samples, what is missing between them counts as withheld (asked_gates.h).
//
// In shared memory a sample is distributed to all readers without conditions, so that the reader skips
// samples. The result is the same: the reader keeps the same budget over the same stamps as the writer's
// gate, by which the writer decides which readers to wake. Samples that the queue pushed out, or that are
// missing because a limit or the path was changed, cannot be looked at any more. The limit entitled the
// reader to one sample in each period, and it can save one: as many as it could not have saved count as lost,
// the rest as withheld. If the writer paused in between, this can be too many, but never too few.
#pragma once

#include <cstdint>
#include <optional>

#include "core/seam/rate_budget.h"
#include "core/seam/sample_origin.h"
#include "core/subscribe/asked_gates.h"

namespace sft::core {

/// Says who keeps the maximum rate that a reader asked for: the writer for samples that it sends by UDP,
/// which are all for the reader, or the reader itself for samples in shared memory.
enum class RateKeeper : std::uint8_t { reader, writer };

class SequenceAccount {
 public:
  /// The limit that the reader asks for; 0: none.
  void ask(std::uint32_t min_period_us) { asked_ = min_period_us; }
  /// So many retained samples of the writer should come first, if there are as many.
  void owe(std::uint32_t samples) { owed_ = samples; }

  /// False if the sample came before, or if later ones were taken already.
  bool is_new(const SampleOrigin& sample) const { return sample.sequence > last_ || begins_anew(sample); }
  /// Notes a sample that is not new. One path is never so far behind another as a forged number can be ahead
  /// of both: the second sample in a row that is so far behind tells that the account begins anew with it.
  void refuse(const SampleOrigin& sample) { far_behind_ = is_far_behind(sample) ? sample.sequence : 0; }
  /// True if the sample comes next, as far as the numbers tell.
  bool follows(const SampleOrigin& sample, const AskedGates& asked) const {
    return sample.sequence == last_ + 1 || begins_anew(sample) || is_next_of_gate(sample, asked);
  }
  /// True if a new sample is for the reader, false if it has to be skipped.
  bool allows(const SampleOrigin& sample, RateKeeper keeper) const;

  struct Missing {
    std::uint64_t lost = 0;
    std::uint64_t withheld = 0;  ///< with the sample itself, if it is skipped
  };
  /// Enters a new sample, to be delivered or skipped as allows() says.
  Missing enter(const SampleOrigin& sample, RateKeeper keeper, const AskedGates& asked);

 private:
  /// Nothing that is larger is believed to be missing where sequences begin anew, or of what was retained.
  static constexpr std::uint64_t gap_max = std::uint64_t{1} << 16;

  bool begins_anew(const SampleOrigin& sample) const {
    return sample.numbering > numbering_ || (is_far_behind(sample) && confirms(sample));
  }
  /// True if all that is missing before the sample was withheld by conditions.
  bool is_next_of_gate(const SampleOrigin& sample, const AskedGates& asked) const {
    return is_of_same_gate(sample) && sample.ordinal == *ordinal_ + 1U &&
           asked.only_gate_since(request_) == sample.gate;
  }
  /// Both that one and the last one have numbers. Retained samples have none, since they passed no gate.
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
  // The sample that was entered last:
  std::uint64_t last_ = 0;  ///< 0: none yet
  std::int64_t stamp_ns_ = 0;
  RateBudget budget_;  ///< of the limit under which it came
  std::optional<std::uint32_t> ordinal_;
  std::uint64_t gate_ = 0;
  AskedGates::Number request_ = 0;  ///< the earliest that can have been in force for it
  std::uint32_t numbering_ = 0;
  std::uint64_t far_behind_ = 0;  ///< the sample refused last, if it was far behind; 0: none
};

}  // namespace sft::core
