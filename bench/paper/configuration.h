// A configuration of the paper's parametric study, and the fields that its receivers need.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

namespace sft::bench::paper {

inline constexpr std::size_t receivers_max = 3;

/// Top-level fields of a message: bit i is its i-th member.
using FieldSet = std::uint32_t;

constexpr FieldSet all_fields(std::size_t fields) { return (FieldSet{1} << fields) - 1; }

struct Configuration {
  std::size_t fields = 0;
  std::size_t field_bytes = 0;
  std::size_t receivers = 0;
  int percent = 0;  ///< the probability that a receiver requires a field

  friend auto operator<=>(const Configuration&, const Configuration&) = default;
};

/// The fields that a receiver requires: each field independently of all others. The same arguments give the
/// same fields on every machine. No field at all is a possible result, and is kept.
FieldSet draw_fields(std::uint64_t seed, const Configuration& of, std::size_t repeat, std::size_t receiver);

}  // namespace sft::bench::paper
