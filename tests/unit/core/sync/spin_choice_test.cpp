// Tests when a thread that waits for samples spins before it sleeps.
#include "core/sync/spin_choice.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

constexpr auto limit = 20us;

class SpinChoiceTest : public testing::Test {
 protected:
  SpinChoice choice{10};
};

TEST_F(SpinChoiceTest, TheFirstWaitSpins) { EXPECT_EQ(choice.spin(limit), limit); }

TEST_F(SpinChoiceTest, NoWaitSpinsWhileSamplesComeSeldom) {
  for (int i = 0; i < 3; ++i) {
    choice.waited(5ms, true, limit);
    EXPECT_EQ(choice.spin(limit), 0ns);
  }
}

TEST_F(SpinChoiceTest, WaitsSpinAgainOnceOneOfThemWasShort) {
  choice.waited(5ms, true, limit);
  choice.waited(201us, true, limit);
  EXPECT_EQ(choice.spin(limit), 0ns);
  choice.waited(200us, true, limit);
  EXPECT_EQ(choice.spin(limit), limit);
}

TEST_F(SpinChoiceTest, ItIsSaidHowManyTimesTheLimitAShortWaitTakes) {
  SpinChoice strict(3);
  strict.waited(61us, true, limit);
  EXPECT_EQ(strict.spin(limit), 0ns);
  strict.waited(60us, true, limit);
  EXPECT_EQ(strict.spin(limit), limit);
}

TEST_F(SpinChoiceTest, NoWaitSpinsAfterOneThatSpunInVain) {
  choice.waited(limit - 1ns, false, limit);
  EXPECT_EQ(choice.spin(limit), limit) << "the deadline came before the spinning ended";
  choice.waited(limit, false, limit);
  EXPECT_EQ(choice.spin(limit), 0ns);
}

TEST_F(SpinChoiceTest, ALongSpinIsKeptForSamplesThatComeWithinIt) {
  choice.waited(5ms, true, 10ms);
  EXPECT_EQ(choice.spin(10ms), 10ms);
}

TEST_F(SpinChoiceTest, AReaderThatWantsNoSpinHasNone) {
  choice.waited(5ns, true, 0ns);
  EXPECT_EQ(choice.spin(0ns), 0ns);
}

}  // namespace
}  // namespace sft::core
