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

struct Busy final : Periodic {
  Time maintain(Time) override {
    ++times;
    if (meanwhile) meanwhile();
    return next;
  }
  Time next = Time::max();
  int times = 0;
  std::function<void()> meanwhile;
};

class PeriodicTasksTest : public testing::Test {
 protected:
  PeriodicTasksTest() { registry.add(one); }
  Busy one, other;
  PeriodicTasks registry;
};

TEST_F(PeriodicTasksTest, KeepsNobodyOutWhileOneIsBusy) {
  std::future<void> added;
  one.meanwhile = [&] {
    added = std::async(std::launch::async, [&] { registry.add(other); });
    EXPECT_EQ(added.wait_for(sft::test::hang_timeout), std::future_status::ready);
  };
  registry.maintain({});
  one.meanwhile = {};
  registry.maintain({});
  EXPECT_EQ(one.times, 2);
  EXPECT_EQ(other.times, 1);
}

TEST_F(PeriodicTasksTest, WantsToBeCalledWhenTheFirstOfThemDoes) {
  registry.add(other);
  EXPECT_EQ(registry.next(), Periodic::Time::max());
  one.next = Periodic::Time(2s);
  other.next = Periodic::Time(3s);
  registry.maintain({});
  EXPECT_EQ(registry.next(), Periodic::Time(2s));
  registry.maintain_by(Periodic::Time(1s));
  EXPECT_EQ(registry.next(), Periodic::Time(1s));
  one.next = Periodic::Time::max();
  registry.maintain({});
  EXPECT_EQ(registry.next(), Periodic::Time(3s));
}

TEST_F(PeriodicTasksTest, LetsOneGoOnlyWhenItIsNotBusyAnyMore) {
  std::atomic<bool> is_gone{false};
  bool was_gone = true;
  std::promise<void> is_busy;
  std::thread remover([&] {
    is_busy.get_future().wait();
    registry.remove(one);
    is_gone = true;
  });
  one.meanwhile = [&] {
    is_busy.set_value();
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
    was_gone = is_gone;
  };
  registry.maintain({});
  remover.join();
  EXPECT_FALSE(was_gone);
  registry.maintain({});
  EXPECT_EQ(one.times, 1);
}

TEST_F(PeriodicTasksTest, SkipsWhoGoesWhileAnotherIsBusy) {
  registry.add(other);
  one.meanwhile = [&] {
    std::async(std::launch::async, [&] { registry.remove(other); }).wait_for(sft::test::hang_timeout);
  };
  registry.maintain({});
  EXPECT_EQ(one.times, 1);
  EXPECT_EQ(other.times, 0);
}

}  // namespace
}  // namespace sft::udp
