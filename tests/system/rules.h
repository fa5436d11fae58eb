// Conditions of which a test knows by itself what they let pass: each is said once as a text for a
// subscriber, and once in C++. The numbers that they judge are the fields row_step of clouds, which mean
// nothing where a cloud has one row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sft::test {

struct Rule {
  std::string conditions;  ///< as they stand in a selection, behind "@"
  /// Says whether the conditions hold for a number that is the at-th one that the gate sees, from 0, if
  /// `former` was the last one that passed. Until one has passed, `at` is 0, and `former` is far from it.
  std::function<bool(std::int64_t number, std::size_t at, std::int64_t former)> holds;
};

/// So many rules, which are all different. Their bounds lie between 0 and 1000.
std::vector<Rule> different_rules(std::size_t count);

/// So many numbers from 0 to 999.
std::vector<std::uint32_t> random_numbers(std::size_t count, std::uint64_t seed);

/// The places, from 0, of the numbers that pass the gate.
std::vector<std::size_t> passing(const Rule& rule, const std::vector<std::uint32_t>& numbers);

}  // namespace sft::test
