// A message as a plain tree of names, counts and bytes, made of an owned struct through its table and of a
// dynamic view: two ways to read one message that must agree.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "sft/dynamic_view.h"
#include "tests/support/owned_value.h"

namespace sft::test {

struct ValueTree {
  std::string name{};
  std::size_t count = 0;           ///< the number of elements
  std::string bytes{};             ///< of a string, or of all primitives of a member
  std::vector<ValueTree> inner{};  ///< members of a struct; elements that are strings or structs
  friend bool operator==(const ValueTree&, const ValueTree&) = default;
};

/// The leaves in `mask` (closed), which are those that were decoded.
ValueTree value_tree(const OwnedValue& value, const FieldMask& mask);

/// Reads the view by iterating over all members and elements. Throws std::logic_error if something that is
/// there cannot be read.
ValueTree value_tree(const DynamicView& view);

/// Reads the view by asking for each member by its name and for each element by its number.
ValueTree value_tree_by_name(const DynamicView& view);

void PrintTo(const ValueTree& tree, std::ostream* out);

}  // namespace sft::test
