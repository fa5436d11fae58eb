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

/// The fields of the mask; of those that have a part just that. The error says which limit is exceeded.
Result<Selection> declared_selection(const FieldMask& mask, const DeclaredParts& parts);

/// The same of a requirement (Req) that is a template argument.
template <auto R>
Result<Selection> declared_selection() {
  constexpr DeclaredParts parts = R.parts;  // clang 16 crashes if it is to pass a member of R on
  return declared_selection(FieldMask(R.mask), parts);
}

/// Says which fields a text of SubscriberOptions asks for.
enum class FieldsOfText : std::uint8_t {
  declared,  ///< those that are declared; of these the text names parts, and no others
  named      ///< those that the text names; all, if it names none
};

template <auto R>
inline constexpr FieldsOfText fields_of_text = R.is_selected ? FieldsOfText::named : FieldsOfText::declared;

/// Returns what such a text asks for, with its gate. A declared field that the text does not name is as it
/// was declared. An error if the text names fields that it must not name.
Result<Selection> selection_of_text(const TypeSupport& type, const Selection& declared, FieldsOfText fields,
                                    std::string_view text);

}  // namespace sft::detail
