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

/// The rate is asked only about samples that fulfil the conditions: the others cost nothing of it.
bool Gate::decide(const detail::FieldSource& sample, std::int64_t stamp_ns) {
  const bool is_first =
      next_passes_.load(std::memory_order_relaxed) && next_passes_.exchange(false, std::memory_order_relaxed);
  is_open_ = is_open_ || is_first;
  const bool holds = conditions_.hold(sample, stamp_ns);
  const bool is_due = (holds || is_first) && budget_.take(stamp_ns);
  const bool passes = is_open_ && (is_due || is_first);
  if (passes) conditions_.passed(sample, stamp_ns);
  return passes;
}

}  // namespace sft::core
