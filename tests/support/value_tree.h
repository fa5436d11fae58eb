// A message as a plain tree of names, counts and bytes. The tree is made from an owned struct by its table,
// or from a dynamic view. Both ways to read a message must give the same tree.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "sft/dynamic_view.h"
#include "tests/support/owned_value.h"

namespace sft::test {

struct ValueTree {
  std::string name{};
  std::size_t count = 0;  ///< the number of elements of the member
  std::string bytes{};    ///< the bytes of a string, or of all primitives of a member
  /// The members of a struct, or the elements if they are strings or structs.
  std::vector<ValueTree> inner{};
  friend bool operator==(const ValueTree&, const ValueTree&) = default;
};

/// Makes the tree of the leaves in `mask`, which must be closed and must contain only decoded leaves.
ValueTree value_tree(const OwnedValue& value, const FieldMask& mask);

/// Makes the tree by iterating over all members and elements of the view. Throws std::logic_error if one of
/// them cannot be read.
ValueTree value_tree(const DynamicView& view);

/// Makes the same tree as value_tree(), but gets each member by its name, and each element by its number.
ValueTree value_tree_by_name(const DynamicView& view);

void PrintTo(const ValueTree& tree, std::ostream* out);

}  // namespace sft::test
