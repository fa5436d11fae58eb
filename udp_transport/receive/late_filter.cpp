#include "udp_transport/receive/late_filter.h"

#include <algorithm>

namespace sft::udp {

bool LateFilter::takes(const core::SampleBuffer& sample, Time now) {
  if (!history_first_) return true;
  const bool alone = sample.addressee != 0;
  if (alone) {
    waits_ = false;
    alone_at_ = now;
  }
  if (!alone && (waits_ || (now - alone_at_ < settling && !follows(sample)))) return false;
  const bool anew = sample.numbering > numbering_;
  // The queue checks if the sample is a duplicate or late.
  if (sample.sequence <= sequence_ && !anew) return true;
  numbering_ = std::max(numbering_, sample.numbering);
  sequence_ = sample.sequence;
  min_period_us_ = sample.min_period_us;
  gate_ = sample.gate;
  ordinal_ = sample.ordinal;
  return true;
}

/// Returns true if no sample between the last taken one and this one is missing. Samples that a maximum rate
/// or conditions withheld are not missing.
bool LateFilter::follows(const core::SampleBuffer& sample) const {
  if (sample.sequence <= sequence_ + 1 || sample.numbering > numbering_) return true;
  const bool is_numbered = sample.min_period_us != 0 || sample.gate != 0;
  return is_numbered && sample.min_period_us == min_period_us_ && sample.gate == gate_ &&
         sample.ordinal == ordinal_ + 1;
}

core::HistoryProgress LateFilter::progress(Time now) const {
  if (!history_first_) return core::HistoryProgress::came;
  if (waits_) return core::HistoryProgress::awaited;
  return now - alone_at_ < settling ? core::HistoryProgress::coming : core::HistoryProgress::came;
}

}  // namespace sft::udp
