#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <thread>

#include "tests/support/eventually.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

struct Busy final : Tended {
  Time tend(Time) override {
    ++times;
    if (meanwhile) meanwhile();
    return next;
  }
  Time next = Time::max();
  int times = 0;
  std::function<void()> meanwhile;
};

class TendedRosterTest : public testing::Test {
 protected:
  TendedRosterTest() { roster.add(one); }
  Busy one, other;
  TendedRoster roster;
};

TEST_F(TendedRosterTest, KeepsNobodyOutWhileOneIsBusy) {
  std::future<void> added;
  one.meanwhile = [&] {
    added = std::async(std::launch::async, [&] { roster.add(other); });
    EXPECT_EQ(added.wait_for(sft::test::patience), std::future_status::ready);
  };
  roster.tend({});
  one.meanwhile = {};
  roster.tend({});
  EXPECT_EQ(one.times, 2);
  EXPECT_EQ(other.times, 1);
}

TEST_F(TendedRosterTest, WantsToBeCalledWhenTheFirstOfThemDoes) {
  roster.add(other);
  EXPECT_EQ(roster.next(), Tended::Time::max());
  one.next = Tended::Time(2s);
  other.next = Tended::Time(3s);
  roster.tend({});
  EXPECT_EQ(roster.next(), Tended::Time(2s));
  roster.tend_by(Tended::Time(1s));
  EXPECT_EQ(roster.next(), Tended::Time(1s));
  one.next = Tended::Time::max();
  roster.tend({});
  EXPECT_EQ(roster.next(), Tended::Time(3s));
}

TEST_F(TendedRosterTest, LetsOneGoOnlyWhenItIsNotBusyAnyMore) {
  std::atomic<bool> is_gone{false};
  bool was_gone = true;
  std::promise<void> is_busy;
  std::thread remover([&] {
    is_busy.get_future().wait();
    roster.remove(one);
    is_gone = true;
  });
  one.meanwhile = [&] {
    is_busy.set_value();
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
    was_gone = is_gone;
  };
  roster.tend({});
  remover.join();
  EXPECT_FALSE(was_gone);
  roster.tend({});
  EXPECT_EQ(one.times, 1);
}

TEST_F(TendedRosterTest, SkipsWhoGoesWhileAnotherIsBusy) {
  roster.add(other);
  one.meanwhile = [&] {
    std::async(std::launch::async, [&] { roster.remove(other); }).wait_for(sft::test::patience);
  };
  roster.tend({});
  EXPECT_EQ(one.times, 1);
  EXPECT_EQ(other.times, 0);
}

}  // namespace
}  // namespace sft::udp
