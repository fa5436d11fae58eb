// Decodes CDR under a mask into the owned struct.
#pragma once

#include "sft/detail/walk.h"

namespace sft::detail {

/// Writes the members that are in `s.mask` to `value`, an owned struct of `type`. Other members keep their
/// values. The body may be hostile: if the status is not ok, only some members were written. Allocates only
/// the memory that the owned struct needs, and never more elements than the remaining bytes can hold. If
/// only the length of a sequence of structs was sent, at most max_empty_elements are made.
WalkStatus decode(const SampleState& s, const StructType& type, void* value);

/// The place of a struct in a sample.
struct StructPlace {
  std::size_t leaf;      ///< the first leaf of the struct
  std::uint64_t offset;  ///< the offset of the struct in the body
};
/// Decodes one struct inside the sample, at `place`, into `value`. The rules are those of decode().
WalkStatus decode_struct(const SampleState& s, const StructType& type, StructPlace place, void* value);

}  // namespace sft::detail
