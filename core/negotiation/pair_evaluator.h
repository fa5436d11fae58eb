// Judges the pairs of one of our endpoints, and limits the number of type definitions that are compared for
// this endpoint.
#pragma once

#include "core/negotiation/endpoint_table.h"
#include "core/negotiation/pair.h"
#include "core/negotiation/type_comparisons.h"

namespace sft::core {

class PairEvaluator {
 public:
  /// Both arguments must outlive this object.
  PairEvaluator(const Self& self, TypeComparisons& comparisons) : self_(self), comparisons_(comparisons) {}

  /// At least one of the two endpoints must be ours.
  Verdict evaluate(const TableEntry& writer, const TableEntry& reader) {
    const bool we_write = writer.is_ours();
    const TypeSupport& type = we_write ? *writer.type : *reader.type;
    const bool differs = writer.endpoint.type_hash != reader.endpoint.type_hash;
    const bool is_compared = !differs || ++definitions_ <= TypeComparisons::compared_at_once;
    return core::evaluate({writer.endpoint, reader.endpoint, we_write}, type, self_,
                          is_compared ? &comparisons_ : nullptr);
  }

 private:
  const Self& self_;
  TypeComparisons& comparisons_;
  int definitions_ = 0;  ///< the number of definitions seen so far that differ from ours
};

}  // namespace sft::core
