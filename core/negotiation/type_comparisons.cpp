#include "core/negotiation/type_comparisons.h"

#include "core/control/described_type.h"
#include "sft/detail/type_shape.h"

namespace sft::core {

namespace {

constexpr std::size_t known_max = 256;
constexpr std::size_t known_bytes_max = std::size_t{8} << 20;

TypeMismatch explain(const TypeSupport& ours, const Endpoint& theirs) {
  TypeMismatch mismatch{.difference = {}, .here = detail::format_shape(ours.type()), .there = {}};
  const Result<DynamicType> type = described_type(theirs);
  if (!type) return mismatch;
  mismatch.difference = detail::first_difference(ours.type(), type->type());
  mismatch.there = detail::format_shape(type->type());
  return mismatch;
}

}  // namespace

std::shared_ptr<const TypeMismatch> TypeComparisons::compare(const TypeSupport& ours,
                                                             const Endpoint& theirs) {
  // A description is accepted only if it has the announced hash. If there is no description yet, it may
  // still come later.
  const bool described = !theirs.type_description.empty();
  const Definitions both{theirs.type_name, ours.hash(), described ? theirs.type_hash : 0};
  if (const auto found = known_.find(both); found != known_.end()) return found->second;
  if (left_ == 0) return std::make_shared<const TypeMismatch>();
  --left_;
  ++compared_;
  auto mismatch = std::make_shared<const TypeMismatch>(explain(ours, theirs));
  if (known_.size() >= known_max || bytes_ >= known_bytes_max) {
    known_.clear();
    bytes_ = 0;
  }
  bytes_ += mismatch->difference.size() + mismatch->here.size() + mismatch->there.size();
  known_.emplace(both, mismatch);
  return mismatch;
}

}  // namespace sft::core
