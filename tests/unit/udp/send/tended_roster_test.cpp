#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "udp_transport/send/send_side.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class TendedRosterTest : public testing::Test {
 protected:
  struct Busy {
    int times = 0;
    std::function<void()> meanwhile = [] {};
    std::shared_ptr<Tended> tended = std::make_shared<Tended>([this](auto) {
      ++times;
      meanwhile();
    });
  };

  TendedRosterTest() { roster.add(one.tended); }
  Busy one, other;
  TendedRoster roster;
};

TEST_F(TendedRosterTest, KeepsNobodyOutWhileOneIsBusy) {
  std::future<void> added;
  one.meanwhile = [&] {
    added = std::async(std::launch::async, [&] { roster.add(other.tended); });
    EXPECT_EQ(added.wait_for(5s), std::future_status::ready);
  };
  roster.tend({});
  one.meanwhile = [] {};
  roster.tend({});
  EXPECT_EQ(one.times, 2);
  EXPECT_EQ(other.times, 1);
}

TEST_F(TendedRosterTest, SkipsOneThatGoesWhileAnotherIsBusy) {
  roster.add(other.tended);
  one.meanwhile = [&] {
    const auto cleared = std::async(std::launch::async, [&] { other.tended->clear(); });
    EXPECT_EQ(cleared.wait_for(5s), std::future_status::ready);
  };
  roster.tend({});
  EXPECT_EQ(one.times, 1);
  EXPECT_EQ(other.times, 0);
}

TEST_F(TendedRosterTest, ForgetsOneThatHasGone) {
  const std::weak_ptr<Tended> gone = one.tended;
  std::exchange(one.tended, nullptr)->clear();
  roster.tend({});
  EXPECT_TRUE(gone.expired());
}

}  // namespace
}  // namespace sft::udp
