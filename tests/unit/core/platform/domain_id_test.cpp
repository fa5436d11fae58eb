#include "core/platform/domain_id.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using ::testing::HasSubstr;

TEST(DomainId, IsWhatTheProgramSaysOrElseTheEnvironmentOrElseZero) {
  EXPECT_EQ(domain_id(7, "8").value(), 7U);
  EXPECT_EQ(domain_id({}, "8").value(), 8U);
  EXPECT_EQ(domain_id({}, nullptr).value(), 0U);
  EXPECT_EQ(domain_id({}, "").value(), 0U);
}

TEST(DomainId, IsAtMost232) {
  EXPECT_EQ(domain_id(232, nullptr).value(), 232U);
  EXPECT_EQ(domain_id({}, "232").value(), 232U);
  EXPECT_THAT(domain_id(233, nullptr).error().message, HasSubstr("NodeOptions::domain is 233"));
  EXPECT_THAT(domain_id({}, "233").error().message, HasSubstr("ROS_DOMAIN_ID is '233'"));
}

TEST(DomainId, InTheEnvironmentIsANumberAndNothingElse) {
  for (const char* text : {"-1", "+1", "1.5", "0x1", " 1", "1 ", "one", "99999999999999999999"}) {
    const auto domain = domain_id({}, text);
    ASSERT_FALSE(domain) << text;
    EXPECT_EQ(domain.error().code, Errc::invalid_argument);
    EXPECT_THAT(domain.error().message, HasSubstr(std::string("ROS_DOMAIN_ID is '") + text + "'"));
    EXPECT_EQ(domain_id(3, text).value(), 3U) << "nobody asked for it";
  }
}

}  // namespace
}  // namespace sft::core
