// Notes that leaves are read whose values are found without their getters.
#pragma once

#include <cstddef>

#include "sft/detail/walk.h"

namespace sft::detail {

/// Notes these leaves, if reads are recorded, and tells whether the sample has all of them as they were
/// published.
inline bool note_leaves(const SampleState& s, std::size_t first, std::size_t count) {
  bool has_each = true;
  for (std::size_t leaf = first; leaf < first + count; ++leaf) {
    const bool present = s.mask->contains(leaf) && (s.log == nullptr || s.log->is_as_published(leaf, 1));
    if (s.log != nullptr) s.log->touch(leaf, present);
    has_each = has_each && present;
  }
  return has_each;
}

}  // namespace sft::detail
