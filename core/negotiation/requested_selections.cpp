#include "core/negotiation/requested_selections.h"

#include "core/negotiation/requested_selection.h"

namespace sft::core {

Result<Selection> RequestedSelections::of(const PairId& pair, const Request& request,
                                          const TypeSupport& type) {
  if (request.parts.empty()) {
    known_.erase(pair);
    return requested_selection(request, type);
  }
  const auto known = known_.find(pair);
  const bool is_known = known != known_.end() && known->second.parts == request.parts &&
                        known->second.mask_words == request.mask_words;
  if (is_known) return known->second.selection;
  ++decoded_;
  Result<Selection> selection = requested_selection(request, type);
  known_.insert_or_assign(pair, Known{request.mask_words, request.parts, selection});
  return selection;
}

}  // namespace sft::core
