#include "udp_transport/send/next_round.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr NextRound::Time now{1h};

TEST(NextRoundTest, ComesAtTheEarliestOfTheTimesThatWereAskedFor) {
  NextRound round;
  EXPECT_EQ(round.time(), NextRound::Time::max()) << "nothing asks for it";
  round.by(now + 2ms);
  round.by(now + 1ms);
  round.by(now + 3ms);
  EXPECT_EQ(round.time(), now + 1ms);
}

TEST(NextRoundTest, ComesAtOnceWhateverElseIsAskedFor) {
  NextRound round;
  round.at_once();
  round.by(now);
  EXPECT_LT(round.time(), now);
}

TEST(NextRoundTest, ForgetsWhatWasAskedForBeforeTheRoundThatBegins) {
  NextRound round;
  round.at_once();
  round.begin();
  EXPECT_EQ(round.time(), NextRound::Time::max());
}

}  // namespace
}  // namespace sft::udp
