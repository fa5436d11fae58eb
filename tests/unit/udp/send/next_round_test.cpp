#include "udp_transport/send/next_round.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(NextRoundTest, ComesAtTheEarliestOfTheTimesThatWereAskedFor) {
  NextRound round;
  EXPECT_EQ(round.time(), NextRound::Time::max()) << "nothing asks for it";
  round.by(test_start + 2ms);
  round.by(test_start + 1ms);
  round.by(test_start + 3ms);
  EXPECT_EQ(round.time(), test_start + 1ms);
}

TEST(NextRoundTest, ComesAtOnceWhateverElseIsAskedFor) {
  NextRound round;
  round.at_once();
  round.by(test_start);
  EXPECT_LT(round.time(), test_start);
}

TEST(NextRoundTest, ForgetsWhatWasAskedForBeforeTheRoundThatBegins) {
  NextRound round;
  round.at_once();
  round.begin();
  EXPECT_EQ(round.time(), NextRound::Time::max());
}

}  // namespace
}  // namespace sft::udp
