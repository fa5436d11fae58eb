// Decodes CDR under a mask to the owned struct.
#pragma once

#include "sft/detail/walk.h"

namespace sft::detail {

/// Writes the members that are in `s.mask` to `value` (an owned struct of `type`); others keep what they
/// hold. The body may be hostile: where the status is not ok, some members were written and some not.
/// Allocates what the owned struct needs and no more than the bytes can justify: of a sequence of structs of
/// which only the length was sent, at most max_empty_elements are made.
WalkStatus decode(const SampleState& s, const StructType& type, void* value);

/// Where a struct within a sample begins.
struct StructPlace {
  std::size_t leaf;      ///< its first one
  std::uint64_t offset;  ///< in the body
};
/// The same for one struct within the sample.
WalkStatus decode_struct(const SampleState& s, const StructType& type, StructPlace place, void* value);

}  // namespace sft::detail
