#include "core/platform/doorbell.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <thread>

namespace sft::core {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

TEST(DoorbellTest, ASleeperIsWokenByARing) {
  const auto page = DoorbellPage::create();
  Doorbell& bell = page->at(3);
  std::atomic<bool> data{false};
  std::thread sleeper([&] {
    while (!data) bell.wait(Clock::time_point::max(), [&] { return data.load(); });
  });
  data = true;
  bell.ring();
  sleeper.join();
}

TEST(DoorbellTest, NoRingIsLostBetweenTheCheckAndTheSleep) {
  const auto page = DoorbellPage::create();
  Doorbell& bell = page->at(0);
  constexpr int rounds = 20'000;
  std::atomic<int> produced{0};
  std::atomic<int> consumed{0};
  std::thread consumer([&] {
    for (int want = 1; want <= rounds; ++want) {
      while (produced < want) bell.wait(Clock::time_point::max(), [&] { return produced >= want; });
      consumed = want;
    }
  });
  for (int i = 1; i <= rounds; ++i) {
    produced = i;
    bell.ring();
  }
  consumer.join();
  EXPECT_EQ(consumed, rounds);
}

TEST(DoorbellTest, WaitingEndsAtItsDeadline) {
  const auto page = DoorbellPage::create();
  const auto deadline = Clock::now() + 20ms;
  page->at(1).wait(deadline, [] { return false; });
  EXPECT_GE(Clock::now(), deadline);
}

TEST(DoorbellTest, ReadyDataIsNotSleptOn) {
  const auto page = DoorbellPage::create();
  page->at(1).wait(Clock::time_point::max(), [] { return true; });
}

TEST(DoorbellTest, AnotherMappingOfThePageRingsTheSameBell) {
  const auto page = DoorbellPage::create();
  if (page->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  const auto other = DoorbellPage::open(page->id());
  ASSERT_TRUE(other) << other.error().message;
  (*other)->at(5).ring();
  EXPECT_EQ(page->at(5).rings.load(), 1U);
}

TEST(DoorbellTest, AnUnknownPageIsAnErrorThatNamesTheFile) {
  const auto page = DoorbellPage::open(0x1234);
  ASSERT_FALSE(page);
  EXPECT_NE(page.error().message.find("sft_bell_0000000000001234"), std::string::npos);
}

// Each ring of a doorbell in such a page would raise SIGBUS.
TEST(DoorbellTest, APageThatWasCutShortIsAnErrorThatNamesTheFile) {
  const auto page = DoorbellPage::create();
  if (page->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  ASSERT_TRUE(DoorbellPage::open(page->id()));
  std::string path(64, ' ');
  std::snprintf(path.data(), path.size(), "/dev/shm/sft_bell_%016llx",
                static_cast<unsigned long long>(page->id()));
  path.resize(path.find('\0'));
  ASSERT_EQ(truncate(path.c_str(), static_cast<off_t>(DoorbellPage::slots * sizeof(Doorbell) - 1)), 0);
  const auto cut = DoorbellPage::open(page->id());
  ASSERT_FALSE(cut);
  EXPECT_NE(cut.error().message.find(path), std::string::npos) << cut.error().message;
}

TEST(DoorbellTest, APageWhoseNameWasRemovedIsFoundInItsProcess) {
  const auto page = DoorbellPage::create();
  const auto named = DoorbellPage::create();
  if (page->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  ASSERT_EQ(unlink(DoorbellPage::path_of(page->id()).c_str()), 0);
  EXPECT_FALSE(DoorbellPage::open(page->id()));
  const auto nameless = DoorbellPage::nameless_pages();
  ASSERT_TRUE(nameless.contains(page->id()));
  EXPECT_FALSE(nameless.contains(named->id()));
  const auto other = DoorbellPage::open_nameless(page->id(), nameless.at(page->id()));
  ASSERT_TRUE(other) << other.error().message;
  (*other)->at(5).ring();
  EXPECT_EQ(page->at(5).rings.load(), 1U);
  EXPECT_FALSE(DoorbellPage::open_nameless(named->id(), nameless.at(page->id())));
}

TEST(DoorbellTest, SweepingRemovesThePagesOfKilledProcessesAndNoOthers) {
  const auto mine = DoorbellPage::create();
  if (mine->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto page = DoorbellPage::create();
    const std::uint64_t id = page->id();
    if (write(pipe_ends[1], &id, sizeof id) != sizeof id) _exit(1);
    pause();
  }
  std::uint64_t id = 0;
  ASSERT_EQ(read(pipe_ends[0], &id, sizeof id), static_cast<ssize_t>(sizeof id));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(pipe_ends[0]);
  close(pipe_ends[1]);

  EXPECT_TRUE(DoorbellPage::open(id));
  DoorbellPage::sweep();
  EXPECT_FALSE(DoorbellPage::open(id));
  EXPECT_TRUE(DoorbellPage::open(mine->id()));
}

}  // namespace
}  // namespace sft::core
