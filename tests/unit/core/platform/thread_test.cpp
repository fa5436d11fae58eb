#include "core/platform/thread.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <future>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

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

TEST(ThreadTest, OfALibraryGetsAPrefixUnlessItWasThereBeforeAndThoseOfTheProgramDoNot) {
  std::promise<void> end;
  const auto wait_for_end = [ended = end.get_future().share()] { ended.wait(); };
  const auto has_thread = [](const ThreadNames& names, const std::string& name) {
    return std::ranges::find(names, name, &ThreadNames::value_type::second) != names.end();
  };
  ThreadNames names;
  auto starter = start_thread("starter", [&] {
    std::vector<std::thread> threads;
    threads.push_back(start_thread("lib-old", wait_for_end).value());
    const ThreadNames before = thread_names();
    for (const char* name : {"lib-new", "program", "receiver-of-a-lib"})
      threads.push_back(start_thread(name, wait_for_end).value());
    prefix_threads_since(before, "nav-", std::array<std::string_view, 2>{"lib-", "recv"});
    names = thread_names();
    end.set_value();
    for (std::thread& thread : threads) thread.join();
  });
  ASSERT_TRUE(starter);
  starter->join();
  for (const char* name : {"lib-old", "nav-lib-new", "program", "receiver-of-a-l", "starter"})
    EXPECT_TRUE(has_thread(names, name)) << name;
}

TEST(ThreadTest, OfALibraryGetsItsPrefixOnceItHasTakenItsName) {
  std::promise<void> end;
  ThreadNames names;
  auto starter = start_thread("starter", [&] {
    const ThreadNames before = thread_names();
    std::thread of_library([&] {
      pthread_setname_np(pthread_self(), "recv");
      end.get_future().wait();
    });
    prefix_threads_since(before, "a-long-prefix-", std::array<std::string_view, 1>{"recv"});
    names = thread_names();
    end.set_value();
    of_library.join();
  });
  ASSERT_TRUE(starter);
  starter->join();
  EXPECT_NE(std::ranges::find(names, "a-long-prefix-r", &ThreadNames::value_type::second), names.end());
}

/// While this object exists, new threads request more stack than there is address space, and cannot start.
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
