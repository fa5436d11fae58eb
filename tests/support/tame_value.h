// Random values that JSON can represent.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "sft/detail/type_table.h"
#include "tests/support/owned_value.h"

namespace sft::test {

/// Changes a value to one that JSON can represent: makes texts ASCII, and replaces each NaN by the quiet NaN
/// `NAN`, because JSON keeps neither the sign nor the payload of a NaN.
inline void tame(const StructType& type, void* object) {
  for (const StructType::Member& m : type.members) {
    const Elements values = elements_of(m, object);
    for (std::size_t i = 0; i < values.count; ++i) {
      auto* at = const_cast<std::byte*>(values.first) + i * m.stride;
      if (m.kind == detail::Kind::structure) tame(*m.type, at);
      if (m.kind == detail::Kind::character) *at &= std::byte{0x7f};
      if (m.kind == detail::Kind::string) {
        for (char& c : *reinterpret_cast<std::string*>(at))
          c = static_cast<char>((c & 0x7f) == 0 ? 'x' : c & 0x7f);
      }
      auto* number32 = reinterpret_cast<float*>(at);
      auto* number64 = reinterpret_cast<double*>(at);
      if (m.kind == detail::Kind::float32 && std::isnan(*number32)) *number32 = NAN;
      if (m.kind == detail::Kind::float64 && std::isnan(*number64)) *number64 = NAN;
    }
  }
}

}  // namespace sft::test
