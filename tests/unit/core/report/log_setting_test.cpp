// Tests where a node writes its log, and which level lines must have at least.
#include "core/report/log_setting.h"

#include <gtest/gtest.h>

#include <string>

namespace sft::core {
namespace {

std::string printed(const LogSetting& setting, LogLevel level, std::string_view line) {
  testing::internal::CaptureStderr();
  setting.sink(level, line);
  return testing::internal::GetCapturedStderr();
}

TEST(LogSettingTest, WithoutASinkWarningsGoToTheStandardError) {
  for (const char* environment : {static_cast<const char*>(nullptr), ""}) {
    const LogSetting setting = log_setting({}, environment);
    EXPECT_EQ(setting.threshold, LogLevel::warning);
    EXPECT_EQ(setting.complaint, "");
    EXPECT_EQ(printed(setting, LogLevel::warning, "node: no daemon"), "[sft] warning: node: no daemon\n");
    EXPECT_EQ(printed(setting, LogLevel::error, "node: ended"), "[sft] error: node: ended\n");
  }
}

TEST(LogSettingTest, TheEnvironmentSaysFromWhichLevelOn) {
  EXPECT_FALSE(log_setting({}, "off").sink);
  EXPECT_EQ(log_setting({}, "error").threshold, LogLevel::error);
  EXPECT_EQ(log_setting({}, "warning").threshold, LogLevel::warning);
  EXPECT_EQ(log_setting({}, "info").threshold, LogLevel::info);
  EXPECT_EQ(log_setting({.log_level = LogLevel::error}, "debug").threshold, LogLevel::debug);
}

TEST(LogSettingTest, AnEnvironmentThatNamesNoLevelIsComplainedOf) {
  const LogSetting setting = log_setting({}, "verbose");
  EXPECT_EQ(setting.threshold, LogLevel::warning);
  EXPECT_EQ(setting.complaint,
            "the environment variable SFT_LOG is 'verbose', which is none of off, error, warning, info and "
            "debug; the log begins at warning");
}

TEST(LogSettingTest, AProgramWithASinkDecidesItself) {
  std::string line;
  NodeOptions options;
  options.log = [&](LogLevel, std::string_view text) { line = text; };
  const LogSetting setting = log_setting(options, "off");
  EXPECT_EQ(setting.threshold, LogLevel::info);
  setting.sink(LogLevel::info, "text");
  EXPECT_EQ(line, "text");
  options.log_level = LogLevel::error;
  EXPECT_EQ(log_setting(options, "debug").threshold, LogLevel::error);
}

TEST(LogSettingTest, AProgramWithoutASinkMayNameTheLevel) {
  EXPECT_EQ(log_setting({.log_level = LogLevel::info}, nullptr).threshold, LogLevel::info);
}

}  // namespace
}  // namespace sft::core
