// Conditions together with a second definition in C++, from which a test knows which samples pass the
// conditions. The conditions apply to the field row_step of clouds, which has no other meaning if a cloud
// has one row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sft::test {

struct Rule {
  std::string conditions;  ///< the text of a selection that follows "@"
  /// Returns true if the conditions hold for `number`. `at` is how many numbers the gate has examined
  /// before this one, and `former` is the last number that passed. Until a number has passed, `at` is 0,
  /// and `former` is far from `number`.
  std::function<bool(std::int64_t number, std::size_t at, std::int64_t former)> holds;
};

/// Returns `count` different rules. Their bounds lie between 0 and 1000.
std::vector<Rule> different_rules(std::size_t count);

/// Returns `count` random numbers from 0 to 999.
std::vector<std::uint32_t> random_numbers(std::size_t count, std::uint64_t seed);

/// Returns the indices in `numbers` of the numbers that pass.
std::vector<std::size_t> passing(const Rule& rule, const std::vector<std::uint32_t>& numbers);

}  // namespace sft::test
