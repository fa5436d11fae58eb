// A publisher that rings for several readers leaves it to the waker to wake the readers that sleep.
#include "shm_transport/wake/doorbell_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "core/seam/gate.h"
#include "tests/support/heap_bytes.h"
#include "tests/support/random_moment.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using core::DoorbellPage;
using shm::DoorbellPages;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto never = 10s;
#ifndef SFT_TEST_SHARE
#define SFT_TEST_SHARE 1
#endif

class SeveralSleepers : public RandomTest {
 protected:
  static constexpr std::size_t count = 3;

  void SetUp() override {
    if (page_->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
    bells_ = pages_.doorbells_of(routes());
  }

  std::vector<core::Route> routes() const {
    std::vector<core::Route> routes;
    for (std::uint32_t slot = 0; slot < count; ++slot) {
      routes.push_back(
          {.reader = slot + 1, .destination = core::DoorbellAddress{page_->id(), slot}, .selection = {}});
    }
    return routes;
  }

  bool is_woken_for(std::size_t which, std::uint64_t round) {
    while (published_ < round) {
      const auto begun = Clock::now();
      page_->at(static_cast<std::uint32_t>(which)).wait(begun + never, [&] { return published_ >= round; });
      if (Clock::now() - begun >= never) return false;
    }
    return true;
  }

  const std::unique_ptr<DoorbellPage> page_ = DoorbellPage::create();
  DoorbellPages pages_;
  std::shared_ptr<const shm::Doorbells> bells_;
  std::atomic<std::uint64_t> published_{0};
  std::array<std::atomic<std::uint64_t>, count> woken_{};
};

TEST_F(SeveralSleepers, NobodyIsWokenIfNobodySleeps) {
  EXPECT_EQ(bells_->announce(), 0U);
  for (std::uint32_t slot = 0; slot < count; ++slot)
    EXPECT_EQ(page_->at(slot).rings, 1U) << "a reader that looks next must see that its doorbell was rung";
}

TEST_F(SeveralSleepers, LeaveNothingWhenTheirPageGoes) {
  const auto come_and_go = [&] {
    const std::unique_ptr<DoorbellPage> page = DoorbellPage::create();
    const auto bells = pages_.doorbells_of(
        {{.reader = 1, .destination = core::DoorbellAddress{page->id(), 0}, .selection = {}}});
    EXPECT_EQ(bells->size(), 1U);
  };
  EXPECT_LT(bytes_left_by(come_and_go), nothing_left);
}

TEST_F(SeveralSleepers, AreToldOnlyOfSamplesThatTheyWant) {
  const auto closed = std::make_shared<core::Gate>(1'000'000);  // No sample has passed this gate yet.
  const auto open = std::make_shared<core::Gate>(0);
  open->consider(detail::FieldSource::of_nothing(), 0);
  ASSERT_TRUE(open->passes());
  const auto page = std::shared_ptr<DoorbellPage>(DoorbellPage::open(page_->id()).value());
  shm::Doorbells bells;
  for (std::uint32_t slot = 0; slot < count; ++slot) {
    page->at(slot).sleepers = 1;
    bells.add(page, slot, closed);
  }
  EXPECT_FALSE(bells.wanted());
  EXPECT_EQ(bells.announce(), 0U);
  bells.add(page, 1, open);
  EXPECT_TRUE(bells.wanted()) << "one of the readers that share doorbell 1 wants the sample";
  EXPECT_EQ(bells.announce(), 1U);
  bells.add(page, 2, nullptr);
  bells.add(page, 2, closed);
  EXPECT_EQ(bells.announce(), 2U) << "one of the readers that share doorbell 2 wants all samples";
  EXPECT_EQ(page->at(0).rings, 0U);
  EXPECT_EQ(page->at(1).rings, 2U);
  EXPECT_EQ(page->at(2).rings, 1U);
}

TEST_F(SeveralSleepers, ThatCannotBeWokenWantTheSampleAllTheSame) {
  shm::Doorbells bells;
  bells.add(nullptr, 0, nullptr);
  EXPECT_TRUE(bells.wanted()) << "a reader that cannot be woken looks for samples by itself";
  EXPECT_EQ(bells.announce(), 0U);
  bells.wake();
}

TEST_F(SeveralSleepers, AreNeverForgotten) {
  const std::uint64_t rounds = test_rounds(10'000 / SFT_TEST_SHARE);
  std::vector<std::thread> sleepers;
  for (std::size_t which = 0; which < count; ++which) {
    sleepers.emplace_back([&, which] {
      RandomMoment moment(which);
      for (std::uint64_t round = 1; round <= rounds; ++round) {
        moment.pass();
        ASSERT_TRUE(is_woken_for(which, round)) << "round " << round;
        woken_[which] = round;
      }
    });
  }
  RandomMoment moment(count);
  const auto all_come_to = [&](std::uint64_t round) {
    return std::all_of(woken_.begin(), woken_.end(), [&](const auto& w) { return comes_to(w, round); });
  };
  for (std::uint64_t round = 1; round <= rounds; ++round) {
    moment.pass();
    published_ = round;
    ring(bells_, pages_.waker());
    if (!all_come_to(round)) break;
  }
  for (std::thread& sleeper : sleepers) sleeper.join();
  EXPECT_EQ(published_, rounds);
}

TEST_F(SeveralSleepers, AreWokenAlsoIfTheListOfDoorbellsIsReplacedAtOnce) {
  const std::uint64_t rounds = test_rounds(1'000 / SFT_TEST_SHARE);
  for (std::uint64_t round = 1; round <= rounds; ++round) {
    std::vector<std::thread> sleepers;
    for (std::size_t which = 0; which < count; ++which) {
      sleepers.emplace_back([&, which] { EXPECT_TRUE(is_woken_for(which, round)) << "round " << round; });
    }
    published_ = round;
    auto bells = std::make_shared<shm::Doorbells>();
    const auto page = std::shared_ptr<DoorbellPage>(DoorbellPage::open(page_->id()).value());
    for (std::uint32_t slot = 0; slot < count; ++slot) bells->add(page, slot, nullptr);
    ring(std::move(bells), pages_.waker());
    for (std::thread& sleeper : sleepers) sleeper.join();
  }
}

TEST_F(SeveralSleepers, AreWokenAlsoIfThePublisherEndsAtOnce) {
  for (std::uint64_t round = 1; round <= 200; ++round) {
    std::vector<std::thread> sleepers;
    for (std::size_t which = 0; which < count; ++which) {
      sleepers.emplace_back([&, which] { EXPECT_TRUE(is_woken_for(which, round)) << "round " << round; });
    }
    {
      DoorbellPages pages;
      const auto bells = pages.doorbells_of(routes());
      published_ = round;
      ring(bells, pages.waker());
    }
    for (std::thread& sleeper : sleepers) sleeper.join();
  }
}

}  // namespace
}  // namespace sft::test
