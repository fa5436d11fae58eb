// Computes offsets in a packed struct (StructType::packed_bytes), which do not depend on the bytes of the
// struct.
#pragma once

#include <cstdint>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// Writes the offset of every slot of a packed struct that begins at `at` to `index`, and advances `index`.
inline void write_packed_slots(const StructType& type, std::uint32_t at, std::uint32_t*& index) {
  for (const Member& m : type.members) {
    if (m.kind == Kind::structure && m.shape == Shape::single) {
      write_packed_slots(*m.type, at, index);
    } else {
      *index++ = at;
    }
    at += m.count * packed_bytes_of(m);
  }
}

}  // namespace sft::detail
