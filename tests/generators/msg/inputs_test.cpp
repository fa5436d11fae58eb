// Stored inputs of fuzz_msg. fuzz_msg.cpp has the checks.
#include <gtest/gtest.h>

#include <filesystem>

#include "from_msg/nested.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace sft::msg {
namespace {

TEST(FuzzInputs, HoldWhatTheFuzzerRequires) {
  int inputs = 0;
  for (const auto& file : std::filesystem::directory_iterator(SFT_MSG_CORPUS)) {
    SCOPED_TRACE(file.path());
    const std::string text = read_file(file.path());
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
    ++inputs;
  }
  EXPECT_GT(inputs, 0);
}

}  // namespace
}  // namespace sft::msg
