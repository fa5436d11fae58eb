// The selection of a program that declares its fields when it is compiled.
#pragma once

#include <string_view>

#include "sft/detail/declared_part.h"
#include "sft/mask.h"
#include "sft/result.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::detail {

/// The fields of the mask; of those that have a part just that. The error says which limit is exceeded.
Result<Selection> declared_selection(const FieldMask& mask, const DeclaredParts& parts);

/// The same of a requirement (Req) that is a template argument.
template <auto R>
Result<Selection> declared_selection() {
  constexpr DeclaredParts parts = R.parts;  // clang 16 crashes if it is to pass a member of R on
  return declared_selection(FieldMask(R.mask), parts);
}

/// The fields of `declared`, but the parts of them and the gate that the text names
/// (SubscriberOptions::selection). A field that the text does not name is as it was declared. An error if the
/// text names other fields.
Result<Selection> selection_within(const TypeSupport& type, const Selection& declared, std::string_view text);

}  // namespace sft::detail
