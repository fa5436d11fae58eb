#include "udp_transport/send/allowance.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Size = ResendWindow::Size;

constexpr Destination::Time now{1h};
constexpr std::uint64_t bytes_per_s = 10'000'000;

class AllowanceTest : public testing::Test, protected test::Sending {
 protected:
  RateLimit limited{bytes_per_s};
};

TEST_F(AllowanceTest, IsTheRoomOfTheDestinationWhereNoRateIsLimited) {
  RateLimit unlimited(0);
  EXPECT_EQ(allowance(*to, unlimited, limit, Size::large, now), to->room(Destination::Size::large, now));
}

TEST_F(AllowanceTest, IsTheLeastOfTheLimits) {
  RateLimit slower(bytes_per_s / 2);
  EXPECT_EQ(allowance(*to, limited, limit, Size::large, now), limited.batch_bytes());
  EXPECT_EQ(allowance(*to, limit, limited, Size::large, now), limited.batch_bytes());
  EXPECT_EQ(allowance(*to, slower, limited, Size::large, now), slower.batch_bytes());
}

TEST_F(AllowanceTest, IsNothingWhileOneLimitIsUsedUp) {
  EXPECT_GT(allowance(*to, limited, limit, Size::small, now), 0U);
  limited.spend(1'000'000);
  EXPECT_EQ(allowance(*to, limited, limit, Size::small, now), 0U);
  EXPECT_EQ(allowance(*to, limit, limited, Size::small, now), 0U);
  EXPECT_GT(allowance(*to, limit, limited, Size::small, now + 1s), 0U);
}

TEST_F(AllowanceTest, LeavesTheLastOfABurstToSmallSamples) {
  EXPECT_GT(allowance(*to, limited, limit, Size::large, now), 0U);
  limited.spend(90'000);  // of a burst of 10 ms
  EXPECT_EQ(allowance(*to, limited, limit, Size::large, now), 0U);
  EXPECT_GT(allowance(*to, limited, limit, Size::small, now), 0U);
}

}  // namespace
}  // namespace sft::udp
