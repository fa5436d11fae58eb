#include "core/type_comparisons.h"

#include "core/described_type.h"
#include "sft/typesupport/type_shape.h"

namespace sft::core {

namespace {

constexpr std::size_t known_max = 256;

TypeMismatch explain(const TypeSupport& ours, const Endpoint& theirs) {
  TypeMismatch mismatch{.difference = {}, .here = format_shape(ours.type()), .there = {}};
  const Result<DynamicType> type = described_type(theirs);
  if (!type) return mismatch;
  mismatch.difference = first_difference(ours.type(), type->type());
  mismatch.there = format_shape(type->type());
  return mismatch;
}

}  // namespace

std::shared_ptr<const TypeMismatch> TypeComparisons::compare(const TypeSupport& ours,
                                                             const Endpoint& theirs) {
  // A description that was accepted has the hash that was announced; without one, another may follow.
  const bool described = !theirs.type_description.empty();
  const Definitions both{theirs.type_name, ours.hash(), described ? theirs.type_hash : 0};
  if (const auto found = known_.find(both); found != known_.end()) return found->second;
  if (known_.size() >= known_max) known_.clear();
  return known_[both] = std::make_shared<const TypeMismatch>(explain(ours, theirs));
}

}  // namespace sft::core
