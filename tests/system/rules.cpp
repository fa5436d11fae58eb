#include "tests/system/rules.h"

#include <cstdlib>
#include <random>

namespace sft::test {

namespace {

/// Returns the n-th rule of one of 8 kinds. The rules for all n from 0 to 99 differ.
Rule rule_of(std::size_t kind, std::int64_t n) {
  const std::int64_t bound = 500 + 4 * n, step = 2 + n;
  const std::string bound_text = std::to_string(bound), step_text = std::to_string(step);
  switch (kind) {
    case 0:
      return {"row_step > " + bound_text, [=](auto number, auto, auto) { return number > bound; }};
    case 1:
      return {"row_step <= " + bound_text, [=](auto number, auto, auto) { return number <= bound; }};
    case 2:
      return {"row_step >= 400 and row_step < " + bound_text,
              [=](auto number, auto, auto) { return number >= 400 && number < bound; }};
    case 3:
      return {"row_step < 100 or row_step > " + bound_text,
              [=](auto number, auto, auto) { return number < 100 || number > bound; }};
    case 4:
      return {"changed(row_step) " + bound_text,
              [=](auto number, auto, auto former) { return std::abs(number - former) > bound; }};
    case 5:
      return {"every " + step_text + "th",
              [=](auto, auto at, auto) { return static_cast<std::int64_t>(at) % step == 0; }};
    case 6:
      return {"row_step > 300 and every " + step_text + "th", [=](auto number, auto at, auto) {
                return number > 300 && static_cast<std::int64_t>(at) % step == 0;
              }};
    default:
      return {"every 20th or (changed(row_step) 50 and row_step != " + bound_text + ")",
              [=](auto number, auto at, auto former) {
                return at % 20 == 0 || (std::abs(number - former) > 50 && number != bound);
              }};
  }
}

}  // namespace

std::vector<Rule> different_rules(std::size_t count) {
  constexpr std::size_t kinds = 8;
  std::vector<Rule> rules;
  for (std::size_t i = 0; i < count; ++i)
    rules.push_back(rule_of(i % kinds, static_cast<std::int64_t>(i / kinds)));
  return rules;
}

std::vector<std::uint32_t> random_numbers(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::uint32_t> any(0, 999);
  std::vector<std::uint32_t> numbers(count);
  for (std::uint32_t& number : numbers) number = any(random);
  return numbers;
}

std::vector<std::size_t> passing(const Rule& rule, const std::vector<std::uint32_t>& numbers) {
  std::vector<std::size_t> places;
  std::int64_t former = -1'000'000;
  for (std::size_t at = 0; at < numbers.size(); ++at) {
    const std::int64_t number = numbers[at];
    if (!rule.holds(number, places.empty() ? 0 : at, former)) continue;
    places.push_back(at);
    former = number;
  }
  return places;
}

}  // namespace sft::test
