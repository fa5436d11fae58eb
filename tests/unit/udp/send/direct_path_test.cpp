// These tests check the samples that the publisher's thread sends itself.
#include "udp_transport/send/direct_path.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

/// Sends small samples until the next one would have to wait. Returns the number of bytes sent.
std::size_t bytes_left_at_once(std::uint64_t node_bytes_per_s) {
  test::Sending sending;
  DirectPath path(std::make_shared<SendSide>(std::make_unique<test::NoSender>(sending.connections),
                                             DestinationLimits{}, node_bytes_per_s),
                  sending.tally);
  const auto lane = sending.lane();
  for (int sample = 0; sample < 2000; ++sample) {
    if (path.send(*lane, *sending.job(test::small_bytes)) != SendOutcome::sent) break;
  }
  return sending.bytes_left();
}

TEST(DirectPathTest, WhatItSendsUsesUpTheRateOfTheWholeNode) {
  constexpr std::size_t burst = 64 * 1024;
  EXPECT_GT(bytes_left_at_once(0), 2 * burst);
  EXPECT_LT(bytes_left_at_once(1000), burst + 10'000);
}

}  // namespace
}  // namespace sft::udp
