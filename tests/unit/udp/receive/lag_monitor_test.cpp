#include "udp_transport/receive/lag_monitor.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class LagMonitorTest : public testing::Test {
 protected:
  LagMonitor::Time now{1h};
  LagMonitor monitor;
};

TEST_F(LagMonitorTest, LooksSoonAtReadersThatHadNoRoom) {
  EXPECT_EQ(monitor.next_look(), LagMonitor::Time::max());
  monitor.begin(now);
  monitor.begin(now + 500us);
  EXPECT_EQ(monitor.next_look(), now + 1ms);
}

TEST_F(LagMonitorTest, LooksEverMoreSeldomWhileTheyTakeNothing) {
  monitor.begin(now);
  for (const auto pause : {2ms, 4ms, 8ms, 16ms, 16ms}) {
    monitor.looked(now, false, true);
    EXPECT_EQ(monitor.next_look(), now + pause);
  }
  monitor.looked(now, true, true);
  EXPECT_EQ(monitor.next_look(), now + 1ms);
}

TEST_F(LagMonitorTest, RestsWhenTheyHaveAll) {
  monitor.begin(now);
  monitor.looked(now, false, true);
  monitor.looked(now, true, false);
  EXPECT_EQ(monitor.next_look(), LagMonitor::Time::max());
  monitor.begin(now);
  EXPECT_EQ(monitor.next_look(), now + 1ms);
}

}  // namespace
}  // namespace sft::udp
