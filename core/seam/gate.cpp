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
  is_first_ =
      next_passes_.load(std::memory_order_relaxed) && next_passes_.exchange(false, std::memory_order_relaxed);
  is_open_ = is_open_ || is_first_;
  const bool holds = conditions_.hold(sample, stamp_ns);
  if (is_first_) {
    budget_.spend(stamp_ns);
    return true;
  }
  return is_open_ && holds && budget_.take(stamp_ns);
}

}  // namespace sft::core
