#include "tests/support/test_seed.h"

#include <charconv>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sft::test {

namespace {

std::uint64_t seed_of_environment() {
  const char* text = std::getenv("SFT_TEST_SEED");
  if (text == nullptr) return std::random_device{}();
  const std::string_view digits = text;
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(digits.begin(), digits.end(), seed);
  if (error != std::errc{} || end != digits.end()) {
    throw std::invalid_argument("SFT_TEST_SEED is not a number: " + std::string(digits));
  }
  return seed;
}

}  // namespace

std::uint64_t test_seed() {
  static const std::uint64_t seed = seed_of_environment();
  return seed;
}

std::string how_to_repeat() { return "to repeat: SFT_TEST_SEED=" + std::to_string(test_seed()); }

RandomTest::RandomTest() : trace_(__FILE__, __LINE__, how_to_repeat()) {
  RecordProperty("seed", std::to_string(test_seed()));
}

}  // namespace sft::test
