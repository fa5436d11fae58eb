#include "core/seam/gate.h"

#include "sft/detail/fnv1a.h"

namespace sft::core {

std::uint64_t gate_id(std::uint64_t conditions, std::uint32_t min_period_us) {
  if (conditions == 0) return 0;
  detail::Fnv1a hash;
  hash.add(conditions);
  hash.add(std::uint64_t{min_period_us});
  return hash.value() == 0 ? 1 : hash.value();
}

/// Only samples that fulfil the conditions count against the rate. The first sample for a reader passes
/// even if it exceeds the maximum rate.
bool Gate::decide(const detail::FieldSource& sample, std::int64_t stamp_ns) {
  if (reader_begins_.load(std::memory_order_relaxed) &&
      reader_begins_.exchange(false, std::memory_order_relaxed)) {
    is_open_ = true;
    conditions_.begin();
  }
  const bool is_first = conditions_.begins();
  if (!conditions_.hold(sample, stamp_ns) || !is_open_) return false;
  if (!is_first) return budget_.take(stamp_ns);
  budget_.spend(stamp_ns);
  return true;
}

}  // namespace sft::core
