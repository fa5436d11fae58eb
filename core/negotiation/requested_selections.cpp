#include "core/negotiation/requested_selections.h"

#include <utility>

#include "core/negotiation/requested_selection.h"

namespace sft::core {

const Result<Selection>& RequestedSelections::of(const PairId& pair, const Request& request,
                                                 const TypeSupport& type) {
  const auto known = known_.find(pair);
  if (known != known_.end() && known->second.is_of(request)) return known->second.selection;
  ++decoded_;
  Known asked{request.mask_words, request.parts, requested_selection(request, type)};
  return known_.insert_or_assign(pair, std::move(asked)).first->second.selection;
}

}  // namespace sft::core
