// The plain sockets with which `sft perf` compares SFT carry whole messages of any size in both directions.
#include "tools/perf/floor.h"

#include <gtest/gtest.h>

#include <future>

namespace sft::perf {
namespace {

using namespace std::chrono_literals;

class FloorTest : public testing::TestWithParam<Socket> {
 protected:
  /// Sends one message, and returns the number that comes back; 0: none.
  std::uint64_t round_trip(std::size_t bytes, std::uint64_t token) {
    std::promise<std::uint64_t> came;
    auto future = came.get_future();
    const auto client = FloorClient::open(GetParam(), "127.0.0.1", server->port(), token, bytes,
                                          [&](std::uint64_t number) { came.set_value(number); });
    if (!client || !(*client)->send(42)) return 0;
    return future.wait_for(token == 7 ? 20s : 500ms) == std::future_status::ready ? future.get() : 0;
  }

  std::unique_ptr<FloorServer> server = FloorServer::open(GetParam(), 7, true).value();
};

TEST_P(FloorTest, AMessageComesBackWhole) {
  for (const std::size_t bytes : {1UL, 24UL, 64UL, 60'000UL, 60'001UL, 150'000UL}) {
    EXPECT_EQ(round_trip(bytes, 7), 42U) << bytes;
  }
  EXPECT_EQ(server->received(), 6U);
}

TEST_P(FloorTest, WhoDoesNotKnowTheNumberOfTheRunGetsNoAnswer) {
  EXPECT_EQ(round_trip(64, 8), 0U);
  EXPECT_EQ(server->received(), 0U);
}

TEST_P(FloorTest, WhoConnectsAndSaysNothingHoldsUpNobody) {
  const auto silent = FloorClient::open(GetParam(), "127.0.0.1", server->port(), 7, 64, [](std::uint64_t) {});
  ASSERT_TRUE(silent);
  EXPECT_EQ(round_trip(64, 7), 42U);
}

INSTANTIATE_TEST_SUITE_P(Sockets, FloorTest, testing::Values(Socket::udp, Socket::tcp));

}  // namespace
}  // namespace sft::perf
