#include "core/platform/thread.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <csignal>
#include <string>
#include <thread>

namespace sft::core {
namespace {

TEST(ThreadTest, HasTheFirst15CharactersOfItsName) {
  std::array<char, 32> name{};
  auto thread = start_thread("sft-agent perception",
                             [&] { pthread_getname_np(pthread_self(), name.data(), name.size()); });
  ASSERT_TRUE(thread);
  thread->join();
  EXPECT_EQ(std::string(name.data()), "sft-agent perce");
}

TEST(ThreadTest, GetsNoneOfTheSignalsOfTheProgramWhoseOwnThreadsGetThemAsBefore) {
  const auto blocks = [](int signal) {
    sigset_t blocked;
    pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    return sigismember(&blocked, signal) == 1;
  };
  bool blocked = false;
  bool may_crash = false;
  auto thread = start_thread("test", [&] {
    blocked = blocks(SIGINT) && blocks(SIGTERM);
    may_crash = !blocks(SIGSEGV);
  });
  ASSERT_TRUE(thread);
  thread->join();
  EXPECT_TRUE(blocked);
  EXPECT_TRUE(may_crash);
  EXPECT_FALSE(blocks(SIGINT));
}

TEST(ThreadTest, OfANodeHasThePrefixThatItsSettingsSay) {
  EXPECT_EQ(ThreadSpec("agent a", ThreadSettings{}).name, "sft-agent a");
  EXPECT_EQ(ThreadSpec("agent a", {.name_prefix = "nav-"}).name, "nav-agent a");
}

TEST(ThreadTest, RunsWhereItsSettingsSayAndElseWhereTheProgramMay) {
  cpu_set_t all, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof all, &all), 0);
  unsigned cpu = 0;
  while (!CPU_ISSET(cpu, &all)) ++cpu;
  CPU_ZERO(&one);
  CPU_SET(cpu, &one);
  const auto of_thread = [](const ThreadSpec& spec) {
    cpu_set_t set;
    CPU_ZERO(&set);
    start_thread(spec, [&] { sched_getaffinity(0, sizeof set, &set); })->join();
    return set;
  };
  const cpu_set_t pinned = of_thread({"pinned", {.cpus = {cpu}}});
  EXPECT_TRUE(CPU_EQUAL(&pinned, &one));
  cpu_set_t of_child;
  std::thread([&] {
    sched_setaffinity(0, sizeof one, &one);
    of_child = of_thread("child");
  }).join();
  EXPECT_TRUE(CPU_EQUAL(&of_child, &all));
}

TEST(ThreadTest, WithSettingsThatTheSystemRefusesIsAnErrorAndDoesNotBegin) {
  bool began = false;
  const auto thread = start_thread({"test", {.cpus = {8000}}}, [&] { began = true; });
  ASSERT_FALSE(thread);
  EXPECT_NE(thread.error().message.find("the thread sft-test: this process may not use CPU 8000"),
            std::string::npos)
      << thread.error().message;
  EXPECT_FALSE(began);
}

/// Threads that are started meanwhile want more stack than there are addresses.
class NoRoomForThreads {
 public:
  NoRoomForThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    pthread_attr_setstacksize(&huge, std::size_t{1} << 48);
    pthread_setattr_default_np(&huge);
    pthread_attr_destroy(&huge);
  }
  ~NoRoomForThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  NoRoomForThreads(const NoRoomForThreads&) = delete;
  NoRoomForThreads& operator=(const NoRoomForThreads&) = delete;

 private:
  pthread_attr_t before_;
};

TEST(ThreadTest, ThatTheSystemRefusesIsAnErrorThatNamesIt) {
  const NoRoomForThreads no_room;
  const auto thread = start_thread("sft-agent", [] {});
  ASSERT_FALSE(thread);
  EXPECT_EQ(thread.error().code, Errc::system);
  EXPECT_NE(thread.error().message.find("sft-agent"), std::string::npos);
}

}  // namespace
}  // namespace sft::core
