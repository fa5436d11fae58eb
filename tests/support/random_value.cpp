#include "tests/support/random_value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "sft/detail/project.h"
#include "tests/support/owned_value.h"

namespace sft::test {

namespace {

using namespace detail;

// Bit patterns of zero, one (as a float it is a denormal), the limits of the ranges, negative zero,
// infinities, and quiet and signalling NaNs with payloads.
constexpr std::array<std::uint64_t, 5> extremes_8{0, 1, 0x7f, 0x80, 0xff};
constexpr std::array<std::uint64_t, 5> extremes_16{0, 1, 0x7fff, 0x8000, 0xffff};
constexpr std::array<std::uint64_t, 10> extremes_32{0,           1,           0x7fff'ffff, 0x8000'0000,
                                                    0xffff'ffff, 0x7f80'0000, 0xff80'0000, 0x7fc0'0001,
                                                    0x7f80'0001, 0x3f80'0000};
constexpr std::array<std::uint64_t, 10> extremes_64{0,
                                                    1,
                                                    0x7fff'ffff'ffff'ffff,
                                                    0x8000'0000'0000'0000,
                                                    0xffff'ffff'ffff'ffff,
                                                    0x7ff0'0000'0000'0000,
                                                    0xfff0'0000'0000'0000,
                                                    0x7ff8'0000'0000'0001,
                                                    0x7ff0'0000'0000'0001,
                                                    0x3ff0'0000'0000'0000};

std::span<const std::uint64_t> extremes(Kind kind) {
  switch (size_of(kind)) {
    case 1:
      return extremes_8;
    case 2:
      return extremes_16;
    case 4:
      return extremes_32;
    default:
      return extremes_64;
  }
}

}  // namespace

FieldMask RandomValues::mask(std::size_t leaves) {
  FieldMask mask(leaves);
  switch (random_() % 8) {
    case 0:
      return FieldMask::full(leaves);
    case 1:
      return mask;
    case 2:
      mask.insert(random_() % leaves);
      return mask;
    default:
      break;
  }
  const std::uint64_t selected_of_16 = 1 + random_() % 15;
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
    if (random_() % 16 < selected_of_16) mask.insert(leaf);
  }
  return mask;
}

void RandomValues::structure(const StructType& type, void* object, int depth) {
  for (const Member& m : type.members) {
    const std::size_t count = m.shape == Shape::sequence ? elements(m, depth) : m.count;
    std::byte* first = resized(m, object, count);
    if (m.enumeration != nullptr && enumerated_ == Enumerated::declared) {
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint64_t value = declared(*m.enumeration);
        std::memcpy(first + i * m.stride, &value, m.stride);
      }
      continue;
    }
    if (is_primitive(m.kind)) {
      block(m.kind, first, count);
      continue;
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::byte* element = first + i * m.stride;
      if (m.kind == Kind::structure) {
        structure(*m.type, element, is_collection(m) ? depth + 1 : depth);
      } else {
        const std::size_t most = m.string_bound == 0 ? SIZE_MAX : m.string_bound;
        *reinterpret_cast<std::string*>(element) = text(most, m.shape == Shape::single ? depth : depth + 1);
      }
    }
  }
}

std::size_t RandomValues::elements(const Member& m, int depth) {
  constexpr std::array<std::size_t, 3> most_bytes{12'000, 100, 40};
  constexpr std::array<std::size_t, 3> most_strings{40, 6, 3};
  constexpr std::array<std::size_t, 3> most_leaves{1'000, 12, 6};
  const auto level = static_cast<std::size_t>(std::min(depth, 2));
  std::size_t most = is_primitive(m.kind)     ? most_bytes[level] / size_of(m.kind)
                     : m.kind == Kind::string ? most_strings[level]
                                              : most_leaves[level] / leaf_count(*m.type) + 1;
  if (m.bound != 0) most = std::min<std::size_t>(most, m.bound);
  return log_uniform(most);
}

void RandomValues::block(Kind kind, std::byte* first, std::size_t count) {
  const std::size_t bytes = count * size_of(kind);
  if (kind == Kind::boolean || count <= 16) {
    for (std::size_t i = 0; i < count; ++i) primitive(kind, first + i * size_of(kind));
    return;
  }
  for (std::size_t at = 0; at < bytes; at += sizeof(std::uint64_t)) {
    const std::uint64_t bits = random_();
    std::memcpy(first + at, &bits, std::min(sizeof bits, bytes - at));
  }
  for (int i = 0; i < 4; ++i) primitive(kind, first + random_() % count * size_of(kind));
}

void RandomValues::primitive(Kind kind, std::byte* value) {
  std::uint64_t bits = random_();
  if (kind == Kind::boolean) {
    bits &= 1;
  } else if (one_in(2)) {
    const std::span<const std::uint64_t> some = extremes(kind);
    bits = some[bits % some.size()];
  }
  std::memcpy(value, &bits, size_of(kind));
}

std::uint64_t RandomValues::declared(const EnumType& type) {
  if (!type.is_bitmask) return type.enumerators[up_to(type.enumerators.size() - 1)].value;
  std::uint64_t flags = 0;
  for (const Enumerator& flag : type.enumerators) flags |= one_in(2) ? flag.value : 0;
  return flags;
}

std::string RandomValues::text(std::size_t most, int depth) {
  const std::size_t usual = depth == 0 && one_in(32) ? 2 * reference_bytes_min : 30;
  std::string text(log_uniform(std::min(most, usual)), '\0');
  for (char& c : text) c = static_cast<char>(1 + random_() % 255);
  return text;
}

std::size_t RandomValues::log_uniform(std::size_t most) {
  const double exponent =
      std::uniform_real_distribution<>(0, std::log(static_cast<double>(most) + 2))(random_);
  return std::min(most, static_cast<std::size_t>(std::exp(exponent)) - 1);
}

}  // namespace sft::test
