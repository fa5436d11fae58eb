#include "core/subscribe/sequence_account.h"

#include <algorithm>

namespace sft::core {

/// Returns the number of samples that passed a gate with conditions between two ordinals. Returns 0 if the
/// number is unknown, because the writer has removed the gate meanwhile and counts from the beginning again.
static std::uint64_t passed_between(std::uint32_t before, std::uint32_t now) {
  const std::uint32_t ahead = now - before;
  return ahead == 0 || ahead > INT32_MAX ? 0 : ahead - 1;
}

bool SequenceAccount::allows(const SampleOrigin& sample, RateKeeper keeper) const {
  if (keeper == RateKeeper::writer || asked_ != budget_.min_period_us()) return true;
  return budget_.allows(sample.source_stamp_ns);
}

SequenceAccount::Missing SequenceAccount::enter(const SampleOrigin& sample, RateKeeper keeper,
                                                const AskedGates& asked) {
  const std::uint64_t gap = gap_before(sample);
  Missing missing;
  missing.lost = gap == 0 ? 0 : std::min(gap, lost_before(sample, keeper, asked, gap));
  missing.withheld = gap - missing.lost;
  if (!allows(sample, keeper)) ++missing.withheld;
  const std::uint32_t limit = limit_of(sample, keeper);
  // The budget begins like that of the writer's gate. With a greater budget, the reader would take a sample
  // in shared memory that the gate withholds, at first or when the samples by UDP end. With a smaller budget,
  // the reader would only skip a sample that the gate of other readers had saved.
  if (budget_.min_period_us() != limit) budget_ = RateBudget(limit, 1);
  budget_.take(sample.source_stamp_ns);
  ordinal_.reset();
  const bool is_numbered = sample.gate == 0 ? limit != 0 : sample.ordinal != 0;
  if (keeper == RateKeeper::writer && is_numbered) ordinal_ = sample.ordinal;
  gate_ = sample.gate;
  request_ = std::max(request_, asked.settled());
  if (keeper == RateKeeper::reader && sample.gate == 0) request_ = asked.open_since(request_);
  last_ = sample.sequence;
  far_behind_ = 0;
  numbering_ = std::max(numbering_, sample.numbering);
  stamp_ns_ = sample.source_stamp_ns;
  return missing;
}

/// Returns the number of sequences that are missing before the sample. Before the first sample that arrived,
/// only retained samples can be missing. If sequences begin anew, a large gap is ignored, because the earlier
/// sequences were wrong.
std::uint64_t SequenceAccount::gap_before(const SampleOrigin& sample) const {
  if (last_ != 0) {
    const std::uint64_t gap = sample.sequence - last_ - 1;
    return begins_anew(sample) && gap >= gap_max ? 0 : gap;
  }
  if (sample.oldest_retained == 0) return std::min<std::uint64_t>(owed_, sample.sequence - 1);
  return std::min(gap_max, sample.sequence - std::min(sample.oldest_retained, sample.sequence));
}

/// Returns how many of the `gap` samples between the last sample and this one were lost. Retained samples
/// have no ordinals, so it is unknown which of them conditions have withheld. If the maximum rate has
/// changed, the slower rate is used. A reader that asks for all samples can also get samples that passed the
/// gates of other readers. Between two such samples, none was withheld from the reader.
std::uint64_t SequenceAccount::lost_before(const SampleOrigin& sample, RateKeeper keeper,
                                           const AskedGates& asked, std::uint64_t gap) const {
  const std::uint32_t limit = limit_of(sample, keeper);
  const std::uint32_t before = budget_.min_period_us();
  const std::optional<std::uint64_t> gate = asked.only_gate_since(request_);
  const bool both_retained = sample.oldest_retained != 0 && sample.ordinal == 0 && !ordinal_;
  if (last_ == 0 || both_retained) return gate == 0 ? gap : 0;
  if (limit == 0 && before == 0 && asked.asks_for_all_since(request_)) return gap;
  if (sample.gate != 0 || gate_ != 0 || gate != 0)
    return gate == sample.gate && is_of_same_gate(sample) ? passed_between(*ordinal_, sample.ordinal) : 0;
  if (limit == 0 && before == 0) return gap;
  if (limit == before && keeper == RateKeeper::writer && ordinal_) return sample.ordinal - *ordinal_ - 1U;
  if (limit <= before) return budget_.forfeited(sample.source_stamp_ns);
  return RateBudget::spent(limit, stamp_ns_).forfeited(sample.source_stamp_ns);
}

}  // namespace sft::core
