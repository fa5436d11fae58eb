#include "core/platform/quotes.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

TEST(QuotesTest, MakeATextShortAndUnableToActOnATerminal) {
  EXPECT_EQ(in_quotes("points"), "'points'");
  EXPECT_EQ(in_quotes("a\nb\x1b"), "'a\\x0ab\\x1b'");
  EXPECT_EQ(in_quotes("\xff\xe2\x80\xae"), "'\\xff\\xe2\\x80\\xae'");
  EXPECT_EQ(in_quotes("grün"), "'grün'");
  const std::string cut = in_quotes(std::string(10'000, 'x'));
  EXPECT_LT(cut.size(), 100U);
  EXPECT_NE(cut.find("(10000 bytes)"), std::string::npos) << cut;
}

}  // namespace
}  // namespace sft::core
