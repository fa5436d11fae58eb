#include "tests/support/test_seed.h"

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sft::test {

namespace {

std::optional<std::uint64_t> number_of_environment(const char* name) {
  const char* text = std::getenv(name);
  if (text == nullptr) return {};
  const std::string_view digits = text;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), number);
  if (error != std::errc{} || end != digits.end()) {
    throw std::invalid_argument(std::string(name) + " is not a number: " + std::string(digits));
  }
  return number;
}

constexpr std::uint64_t fixed_seed = 1;

std::uint64_t seed_of_environment() {
  if (const auto given = number_of_environment("SFT_TEST_SEED")) return *given;
  return std::getenv("SFT_TEST_FIXED_SEEDS") != nullptr ? fixed_seed : std::random_device{}();
}

/// Prints the seed at the beginning, because a test that hangs or crashes prints no failure.
std::uint64_t reported(std::uint64_t seed) {
  std::fprintf(stderr, "random numbers: SFT_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed));
  return seed;
}

}  // namespace

std::uint64_t test_seed() {
  static const std::uint64_t seed = reported(seed_of_environment());
  return seed;
}

std::uint64_t test_rounds(std::uint64_t usual) {
  static const std::uint64_t times = number_of_environment("SFT_TEST_TIMES").value_or(1);
  return usual * times;
}

std::string how_to_repeat() { return "to repeat: SFT_TEST_SEED=" + std::to_string(test_seed()); }

RandomTest::RandomTest() : trace_(__FILE__, __LINE__, how_to_repeat()) {
  RecordProperty("seed", std::to_string(test_seed()));
}

}  // namespace sft::test
