#include "core/node/vanilla_choice.h"

#include <gmock/gmock.h>

namespace sft::core {
namespace {

using enum NodeOptions::VanillaDds;

TEST(VanillaChoice, IsWhatTheProgramSaysOrElseTheEnvironmentOrElseAutomatic) {
  EXPECT_EQ(vanilla_choice(never, "always").value(), never);
  EXPECT_EQ(vanilla_choice({}, "always").value(), always);
  EXPECT_EQ(vanilla_choice({}, "never").value(), never);
  EXPECT_EQ(vanilla_choice({}, "auto").value(), automatic);
  EXPECT_EQ(vanilla_choice({}, nullptr).value(), automatic);
  EXPECT_EQ(vanilla_choice({}, "").value(), automatic);
}

TEST(VanillaChoice, InTheEnvironmentIsOneOfThreeWords) {
  const auto choice = vanilla_choice({}, "on");
  ASSERT_FALSE(choice);
  EXPECT_EQ(choice.error().code, Errc::invalid_argument);
  EXPECT_THAT(choice.error().message, testing::HasSubstr("SFT_VANILLA_DDS is 'on'"));
  EXPECT_EQ(vanilla_choice(always, "on").value(), always) << "nobody asked for it";
}

TEST(DdsNamesChoice, IsWhatTheProgramSaysOrElseTheEnvironmentOrElseThatOfRos2) {
  using enum NodeOptions::DdsNames;
  EXPECT_EQ(dds_names_choice(ros2, "plain").value(), ros2);
  EXPECT_EQ(dds_names_choice({}, "plain").value(), plain);
  EXPECT_EQ(dds_names_choice({}, "ros2").value(), ros2);
  EXPECT_EQ(dds_names_choice({}, nullptr).value(), ros2);
  EXPECT_THAT(dds_names_choice({}, "ros").error().message, testing::HasSubstr("SFT_DDS_NAMES is 'ros'"));
}

}  // namespace
}  // namespace sft::core
