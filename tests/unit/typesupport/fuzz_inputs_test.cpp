// This test does briefly, and under any compiler, the work of a fuzzer: it runs the stored inputs and
// randomly damaged copies of them. The fuzzer's fuzz_*.cpp, which is linked with this test, has the checks.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/recorded_data.h"
#include "tests/support/test_seed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace sft::test {
namespace {

class SFT_FUZZ_TEST_NAME : public RandomTest {
 protected:
  SFT_FUZZ_TEST_NAME() {
    for (const auto& file : std::filesystem::directory_iterator(SFT_FUZZ_CORPUS))
      inputs.push_back(read_recording(file.path()).value());
    std::ranges::sort(
        // File systems list files in different orders, but a seed has to give the same test everywhere.
        inputs);
  }

  static void try_input(const std::vector<std::byte>& input) {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  }

  void damage(std::vector<std::byte>& input) {
    for (std::uint64_t i = random() % 4; i > 0 && !input.empty(); --i)
      input[random() % input.size()] = static_cast<std::byte>(random() >> random() % 8);
    input.resize(input.size() - std::min<std::size_t>(input.size(), random() % 5));
  }

  std::vector<std::vector<std::byte>> inputs;
};

TEST_F(SFT_FUZZ_TEST_NAME, OfTheKeptCorpusHoldWhatTheFuzzerRequires) {
  EXPECT_FALSE(inputs.empty());
  for (const auto& input : inputs) EXPECT_NO_THROW(try_input(input));
}

TEST_F(SFT_FUZZ_TEST_NAME, ThatAreDamagedAreRefusedOrHoldItAsWell) {
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::byte> input = inputs[random() % inputs.size()];
    damage(input);
    ASSERT_NO_THROW(try_input(input)) << "in round " << round;
  }
}

}  // namespace
}  // namespace sft::test
