// Checks the layout rules of a message against the fields that they name.
#pragma once

#include <functional>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Returns the definition of a nested type; null if it is not known.
using FindDefinition = std::function<const Definition*(const TypeName&)>;

/// Returns the mistakes in the rules of the definition.
std::vector<Problem> check_layouts(const Definition& definition, const FindDefinition& find);

/// Returns the canonical spelling of a field's rule, which parse() has accepted; empty if it has none.
std::string layout_text(const Field& field);

}  // namespace sft::msg
