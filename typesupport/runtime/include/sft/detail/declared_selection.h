// The selection of a program that declares its fields when it is compiled.
#pragma once

#include <cstdint>
#include <string_view>

#include "sft/detail/declared_part.h"
#include "sft/mask.h"
#include "sft/result.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::detail {

/// Returns the selection of the fields of the mask, and of a field with a part just the part. The error says
/// which limit is exceeded.
Result<Selection> declared_selection(const FieldMask& mask, const DeclaredParts& parts);

/// The same for a requirement (Req) that is a template argument.
template <auto R>
Result<Selection> declared_selection() {
  constexpr DeclaredParts parts = R.parts;  // clang 16 crashes if it passes a member of R directly
  return declared_selection(FieldMask(R.mask), parts);
}

/// The fields for which a text of SubscriberOptions asks.
enum class FieldsOfText : std::uint8_t {
  declared,  ///< all declared fields; the text names parts of them, and no other fields
  named      ///< the fields that the text names; all if it names none
};

template <auto R>
inline constexpr FieldsOfText fields_of_text = R.is_selected ? FieldsOfText::named : FieldsOfText::declared;

/// Returns the selection for which such a text asks, with its gate. A declared field that the text does not
/// name stays as it was declared. Returns an error if the text names other fields than it may.
Result<Selection> selection_of_text(const TypeSupport& type, const Selection& declared, FieldsOfText fields,
                                    std::string_view text);

}  // namespace sft::detail
