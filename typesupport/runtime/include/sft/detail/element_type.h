// The types that the elements of collections have in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// True if a collection with elements of that kind consists of objects of type E in memory.
template <class E>
constexpr bool holds(Kind kind) {
  if constexpr (std::is_same_v<E, std::byte>) return kind == Kind::octet || kind == Kind::uint8;
  if constexpr (std::is_same_v<E, char>) return kind == Kind::character;
  if constexpr (std::is_same_v<E, std::uint8_t>)
    return kind == Kind::boolean || kind == Kind::octet || kind == Kind::uint8;
  if constexpr (std::is_same_v<E, std::int8_t>) return kind == Kind::int8;
  if constexpr (std::is_same_v<E, std::int16_t>) return kind == Kind::int16;
  if constexpr (std::is_same_v<E, std::uint16_t>) return kind == Kind::uint16;
  if constexpr (std::is_same_v<E, std::int32_t>) return kind == Kind::int32;
  if constexpr (std::is_same_v<E, std::uint32_t>) return kind == Kind::uint32;
  if constexpr (std::is_same_v<E, std::int64_t>) return kind == Kind::int64;
  if constexpr (std::is_same_v<E, std::uint64_t>) return kind == Kind::uint64;
  if constexpr (std::is_same_v<E, float>) return kind == Kind::float32;
  if constexpr (std::is_same_v<E, double>) return kind == Kind::float64;
  return false;
}

}  // namespace sft::detail
