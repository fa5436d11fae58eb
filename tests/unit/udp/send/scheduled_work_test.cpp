#include "udp_transport/send/scheduled_work.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "tests/unit/udp/send/sending.h"

namespace sft::udp {
namespace {

struct Work final : DeferredWork {
  bool carry_out() noexcept override {
    ++times;
    if (meanwhile) meanwhile();
    return times < parts;
  }
  int times = 0, parts = 1;
  std::function<void()> meanwhile;
};

class ScheduledWorkTest : public testing::Test, protected test::Sending {
 protected:
  ScheduledWork::Taken take() {
    ScheduledWork::Taken taken;
    scheduled.take(taken);
    return taken;
  }
};

TEST_F(ScheduledWorkTest, WakesTheSendingThreadForTheFirstLaneThatItHasNotTaken) {
  scheduled.add(lane());
  scheduled.add(lane());
  EXPECT_EQ(connections.woken(), 1U);
  EXPECT_EQ(take().lanes.size(), 2U);
  EXPECT_TRUE(take().lanes.empty());
  scheduled.add(lane());
  EXPECT_EQ(connections.woken(), 2U);
}

TEST_F(ScheduledWorkTest, WakesTheSendingThreadForAChannel) {
  scheduled.add(channel());
  EXPECT_EQ(connections.woken(), 1U);
  EXPECT_EQ(take().channels.size(), 1U);
  EXPECT_TRUE(take().channels.empty());
}

TEST_F(ScheduledWorkTest, NeedsMemoryTwiceHoweverOftenThereIsNothingToTake) {
  ScheduledWork::Taken taken;
  const auto memory_of_next = [&] {
    scheduled.add(lane());
    scheduled.add(channel());
    scheduled.take(taken);
    const std::pair memory{taken.lanes.data(), taken.channels.data()};
    taken.lanes.clear();
    taken.channels.clear();
    return memory;
  };
  for (int looks_in_vain = 0; looks_in_vain < 3; ++looks_in_vain) {
    SCOPED_TRACE(looks_in_vain);
    const auto first = memory_of_next();
    for (int i = 0; i < looks_in_vain; ++i) scheduled.take(taken);
    const auto second = memory_of_next();
    EXPECT_NE(first, second);
    EXPECT_EQ(memory_of_next(), first);
    EXPECT_EQ(memory_of_next(), second);
  }
}

TEST_F(ScheduledWorkTest, CarriesOutDeferredWorkOnce) {
  const auto one = std::make_shared<Work>();
  const auto other = std::make_shared<Work>();
  scheduled.add(one);
  scheduled.add(other);
  scheduled.carry_out_deferred();
  scheduled.carry_out_deferred();
  EXPECT_EQ(one->times, 1);
  EXPECT_EQ(other->times, 1);
}

TEST_F(ScheduledWorkTest, GivesOtherWorkItsTurnBetweenTwoPartsOfOne) {
  const auto endless = std::make_shared<Work>();
  const auto rare = std::make_shared<Work>();
  endless->parts = 1000;
  scheduled.add(endless);
  scheduled.carry_out_deferred();
  EXPECT_EQ(endless->times, 1);
  scheduled.add(rare);
  scheduled.carry_out_deferred();
  EXPECT_EQ(rare->times, 1);
  EXPECT_EQ(endless->times, 2) << "nobody adds it again";
}

TEST_F(ScheduledWorkTest, TakesWorkAgainWhileItIsCarriedOut) {
  const auto work = std::make_shared<Work>();
  const auto before = std::make_shared<Work>();
  work->meanwhile = [&] { scheduled.add(work); };
  scheduled.add(before);
  scheduled.add(work);
  scheduled.carry_out_deferred();
  EXPECT_EQ(work->times, 1) << "work that is added meanwhile waits for the next call";
  EXPECT_EQ(before->times, 1);
  work->meanwhile = {};
  scheduled.carry_out_deferred();
  EXPECT_EQ(work->times, 2);
  EXPECT_EQ(before->times, 1);
}

TEST_F(ScheduledWorkTest, KeepsNothingOnceItIsClosed) {
  const auto one_lane = lane();
  const auto one_channel = channel();
  const auto work = std::make_shared<Work>();
  const auto add_all = [&] {
    scheduled.add(one_lane);
    scheduled.add(one_channel);
    scheduled.add(work);
  };
  add_all();
  EXPECT_EQ(work.use_count(), 2);
  scheduled.close();
  add_all();
  EXPECT_EQ(one_lane.use_count(), 1);
  EXPECT_EQ(one_channel.use_count(), 1);
  EXPECT_EQ(work.use_count(), 1);
  EXPECT_EQ(connections.woken(), 3U) << "nobody is woken for what is refused";
}

}  // namespace
}  // namespace sft::udp
