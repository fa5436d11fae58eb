// The message types for tests of conditions.
#pragma once

#include <torture.hpp>
#include <vector>

#include "tests/support/gate_reference.h"
#include "tests/support/message_types.h"

namespace sft::test {

/// Returns the types that have fields which are single values. Types with values of all kinds are repeated,
/// so that they are chosen often.
inline std::vector<MessageType> types_with_single_values() {
  std::vector<MessageType> types;
  for (const MessageType& type : all_types())
    if (!single_fields(type.type()).empty()) types.push_back(type);
  for (int i = 0; i < 4; ++i) {
    types.push_back(message_type<torture::Primitives>());
    types.push_back(message_type<torture::Defaults>());
  }
  types.push_back(message_type<torture::Bitmasks>());
  return types;
}

}  // namespace sft::test
