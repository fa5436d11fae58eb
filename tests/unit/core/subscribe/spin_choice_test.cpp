// These tests check when a wait for samples spins before it sleeps.
#include "core/subscribe/spin_choice.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

constexpr auto brief_spin = 20us;

TEST(SpinChoiceTest, TheFirstWaitSpins) { EXPECT_EQ(SpinChoice(brief_spin).spin(), brief_spin); }

TEST(SpinChoiceTest, NoWaitSpinsWhileSamplesComeSeldom) {
  SpinChoice choice(brief_spin);
  for (int i = 0; i < 3; ++i) {
    choice.waited(5ms, true);
    EXPECT_EQ(choice.spin(), 0ns);
  }
}

TEST(SpinChoiceTest, WaitsSpinAgainOnceOneOfThemWasShort) {
  SpinChoice choice(brief_spin);
  choice.waited(5ms, true);
  choice.waited(201us, true);
  EXPECT_EQ(choice.spin(), 0ns);
  choice.waited(200us, true);
  EXPECT_EQ(choice.spin(), brief_spin);
}

TEST(SpinChoiceTest, NoWaitSpinsAfterOneThatSpunInVain) {
  SpinChoice choice(brief_spin);
  choice.waited(brief_spin - 1ns, false);
  EXPECT_EQ(choice.spin(), brief_spin) << "the deadline came before the spinning ended";
  choice.waited(brief_spin, false);
  EXPECT_EQ(choice.spin(), 0ns);
}

TEST(SpinChoiceTest, ALongSpinIsKeptForSamplesThatComeWithinIt) {
  SpinChoice choice(10ms);
  choice.waited(5ms, true);
  EXPECT_EQ(choice.spin(), 10ms);
}

TEST(SpinChoiceTest, WhoeverWantsNoSpinHasNone) {
  SpinChoice choice(0ns);
  choice.waited(5ns, true);
  EXPECT_EQ(choice.spin(), 0ns);
}

}  // namespace
}  // namespace sft::core
