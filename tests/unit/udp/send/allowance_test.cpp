#include "udp_transport/send/allowance.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/send/sending.h"
#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using KeptSize = ResendWindow::Size;

constexpr std::uint64_t bytes_per_s = 10'000'000;

class AllowanceTest : public testing::Test, protected test::Sending {
 protected:
  RateLimit limited{bytes_per_s};
};

TEST_F(AllowanceTest, IsTheRoomOfTheDestinationWhereNoRateIsLimited) {
  RateLimit unlimited(0);
  EXPECT_EQ(allowance(*to, unlimited, limit, KeptSize::large, test_start),
            to->room(Destination::Size::large, test_start));
}

TEST_F(AllowanceTest, IsTheLeastOfTheLimits) {
  RateLimit slower(bytes_per_s / 2);
  EXPECT_EQ(allowance(*to, limited, limit, KeptSize::large, test_start), limited.batch_bytes());
  EXPECT_EQ(allowance(*to, limit, limited, KeptSize::large, test_start), limited.batch_bytes());
  EXPECT_EQ(allowance(*to, slower, limited, KeptSize::large, test_start), slower.batch_bytes());
}

TEST_F(AllowanceTest, IsNothingWhileOneLimitIsUsedUp) {
  EXPECT_GT(allowance(*to, limited, limit, KeptSize::small, test_start), 0U);
  limited.spend(1'000'000);
  EXPECT_EQ(allowance(*to, limited, limit, KeptSize::small, test_start), 0U);
  EXPECT_EQ(allowance(*to, limit, limited, KeptSize::small, test_start), 0U);
  EXPECT_GT(allowance(*to, limit, limited, KeptSize::small, test_start + 1s), 0U);
}

TEST_F(AllowanceTest, LeavesTheLastOfABurstToSmallSamples) {
  EXPECT_GT(allowance(*to, limited, limit, KeptSize::large, test_start), 0U);
  limited.spend(90'000);  // most of the bytes that the rate limit allows for 10 ms
  EXPECT_EQ(allowance(*to, limited, limit, KeptSize::large, test_start), 0U);
  EXPECT_GT(allowance(*to, limited, limit, KeptSize::small, test_start), 0U);
}

}  // namespace
}  // namespace sft::udp
