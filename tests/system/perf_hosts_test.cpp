// `sft perf` between two hosts with a cable that loses frames.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/support/test_seed.h"
#include "tests/support/tool_process.h"
#include "tests/system/lossy_cable.h"

namespace sft::test {
namespace {

TEST(PerfHostsTest, ALossOfFivePercentIsToldAsThatForBothDirections) {
  const auto cable = LossyCable::create({.loss = 0.05, .repetition = 0, .swap = 0}, test_seed());
  if (!cable) GTEST_SKIP() << cable.error().message;
  ASSERT_TRUE((*cable)->host(1).enter());
  ToolProcess pong({"perf", "pong"});
  ASSERT_TRUE(pong.prints("waits in domain"));
  ASSERT_TRUE((*cable)->host(0).enter());
  (*cable)->become(true);
  const Ended ended =
      run_tool({"perf", "ping", "--transport", "udp", "--rate", "1000", "--for", "8", "--json"});
  (*cable)->become(false);
  ASSERT_TRUE(nlohmann::json::accept(ended.out)) << ended.out << ended.err;
  const nlohmann::json lane = nlohmann::json::parse(ended.out)["lanes"][0];
  const auto sent = lane["sent"].get<double>(), arrived = lane["arrived"].get<double>();
  ASSERT_EQ(sent, 8000) << ended.out << ended.err;
  EXPECT_NEAR(lane["lost_there"].get<double>() / sent, 0.05, 0.01) << ended.out;
  EXPECT_NEAR(lane["lost_back"].get<double>() / arrived, 0.05, 0.01) << ended.out;
}

}  // namespace
}  // namespace sft::test
