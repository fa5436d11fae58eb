// The time for which a destination counts as unsettled. settled_readers_test.cpp tests the consequences for
// multicast groups.
#include "udp_transport/routing/settling_times.h"

#include <gtest/gtest.h>

#include "tests/support/heap_bytes.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(SettlingTimesTest, LeaveNothingOfDestinationsThatLeft) {
  SettlingTimes times;
  SettlingTimes::Time now{1h};
  std::uint32_t address = 0;
  const auto come_and_go = [&] {
    times.begin_look();
    times.note({core::IpAddress(++address), 7000}, {}, now);
    times.end_look(now);
    times.begin_look();
    times.end_look(now);
    now += SettlingTimes::row_pause;
    times.begin_look();
    times.end_look(now);
  };
  EXPECT_LT(sft::test::bytes_left_by(come_and_go), sft::test::nothing_left);
}

}  // namespace
}  // namespace sft::udp
