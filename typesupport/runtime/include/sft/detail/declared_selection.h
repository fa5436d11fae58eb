// Makes the selection of a program that declares its fields when it is compiled.
#pragma once

#include <cstdint>
#include <string_view>

#include "sft/detail/declared_part.h"
#include "sft/mask.h"
#include "sft/result.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::detail {

/// Returns the selection of the fields in the mask. A field with a declared part is selected only in that
/// part. The error says which limit is exceeded.
Result<Selection> declared_selection(const FieldMask& mask, const DeclaredParts& parts);

/// Returns the selection of a requirement (Req) that is a template argument.
template <auto R>
Result<Selection> declared_selection() {
  constexpr DeclaredParts parts = R.parts;  // clang 16 crashes if it passes a member of R directly
  return declared_selection(FieldMask(R.mask), parts);
}

/// The fields that a text of SubscriberOptions requests.
enum class FieldsOfText : std::uint8_t {
  declared,  ///< all declared fields; the text may name parts of them, but no other fields
  named      ///< the fields that the text names; all fields if it names none
};

template <auto R>
inline constexpr FieldsOfText fields_of_text = R.is_selected ? FieldsOfText::named : FieldsOfText::declared;

/// Returns the selection that the text requests, with its gate. A declared field that the text does not
/// name stays as it was declared. Returns an error if the text names fields that it must not name.
Result<Selection> selection_of_text(const TypeSupport& type, const Selection& declared, FieldsOfText fields,
                                    std::string_view text);

}  // namespace sft::detail
