#include "udp_transport/receive/lag_watch.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class LagWatchTest : public testing::Test {
 protected:
  LagWatch::Time now{1h};
  LagWatch watch;
};

TEST_F(LagWatchTest, LooksSoonAtReadersThatHadNoRoom) {
  EXPECT_EQ(watch.next_look(), LagWatch::Time::max());
  watch.begin(now);
  watch.begin(now + 500us);
  EXPECT_EQ(watch.next_look(), now + 1ms);
}

TEST_F(LagWatchTest, LooksEverMoreSeldomWhileTheyTakeNothing) {
  watch.begin(now);
  for (const auto pause : {2ms, 4ms, 8ms, 16ms, 16ms}) {
    watch.looked(now, false, true);
    EXPECT_EQ(watch.next_look(), now + pause);
  }
  watch.looked(now, true, true);
  EXPECT_EQ(watch.next_look(), now + 1ms);
}

TEST_F(LagWatchTest, RestsWhenTheyHaveAll) {
  watch.begin(now);
  watch.looked(now, false, true);
  watch.looked(now, true, false);
  EXPECT_EQ(watch.next_look(), LagWatch::Time::max());
  watch.begin(now);
  EXPECT_EQ(watch.next_look(), now + 1ms);
}

}  // namespace
}  // namespace sft::udp
