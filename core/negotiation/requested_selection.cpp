#include "core/negotiation/requested_selection.h"

#include <span>

namespace sft::core {

Result<Selection> requested_selection(const Request& request, const TypeSupport& type) {
  const FieldMask fields = FieldMask::from_words(type.leaves(), request.mask_words);
  if (request.parts.empty()) return Selection(type.closed(fields));
  const Result<Selection> some = Selection::from_bytes(request.parts, type.leaves());
  if (!some) return some;
  const std::span<const Selection::Part> parts = some->parts();
  return Selection::make(fields, {parts.begin(), parts.end()}, {}).map([&type](const Selection& all) {
    return type.closed(all);
  });
}

}  // namespace sft::core
