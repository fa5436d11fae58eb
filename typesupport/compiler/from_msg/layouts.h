// Checks the layout rules of a message against the fields that they name.
#pragma once

#include <functional>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Returns the definition of a nested type; null if the definition is not known.
using FindDefinition = std::function<const Definition*(const TypeName&)>;

/// Returns the mistakes in the rules of the definition.
std::vector<Problem> check_layouts(const Definition& definition, const FindDefinition& find);

/// Returns the canonical spelling of a field's rule; empty if the field has no rule. parse() must have
/// accepted the rule.
std::string layout_text(const Field& field);

}  // namespace sft::msg
