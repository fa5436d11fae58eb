// Random messages of any type, and random masks. The numbers of elements are log-uniform: mostly small,
// sometimes so large that the elements exceed a piece that is copied at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "sft/detail/type_table.h"
#include "sft/mask.h"
#include "tests/support/test_seed.h"

namespace sft::test {

/// The values that enumerations and bitmasks get: any integer, or only integers that the IDL declares.
/// Cyclone DDS accepts only declared integers.
enum class Enumerated { any, declared };

class RandomValues {
 public:
  explicit RandomValues(Random& random, Enumerated enumerated = Enumerated::any)
      : random_(random), enumerated_(enumerated) {}

  /// Fills all leaves. Numbers get any bits, often extremes and NaNs. Booleans are 0 or 1, and strings have
  /// no NUL. Sequences and strings keep within their bounds.
  void fill(const StructType& type, void* value) { structure(type, value, 0); }

  /// Returns a mask that is dense, sparse, empty or full, or has a single leaf. The mask is not closed.
  FieldMask mask(std::size_t leaves);

  std::size_t up_to(std::size_t most) { return random_() % (most + 1); }

 private:
  void structure(const StructType& type, void* object, int depth);
  std::size_t elements(const StructType::Member& member, int depth);
  void block(detail::Kind kind, std::byte* first, std::size_t count);
  std::uint64_t declared(const EnumType& type);
  void primitive(detail::Kind kind, std::byte* value);
  std::string text(std::size_t most, int depth);
  std::size_t log_uniform(std::size_t most);
  bool one_in(std::uint64_t n) { return random_() % n == 0; }

  Random& random_;
  Enumerated enumerated_;
};

}  // namespace sft::test
