// A small sample between two sleeping nodes takes a limited number of wake-ups and system calls. The tests
// compare these counts instead of times, because each wake-up and each system call costs some microseconds
// on any machine.
//
// The counts for a sample are taken between two times at which all threads of both processes sleep. The
// lower quartile over the samples excludes other work of the nodes, such as discovery.
#include <gtest/gtest.h>
#include <semaphore.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "bench/common/counters.h"
#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"
#include "tests/system/node_process.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using bench::Counts;
using bench::ProcessCounter;
using bench::ThreadCounts;

constexpr std::size_t samples = 25;
constexpr std::size_t samples_max = 1500;  // a callback counts as slow until many quick ones have followed

struct Report {
  std::atomic<bool> failed{false};
  std::atomic<bool> served{false};
  std::atomic<pid_t> process{0};
  std::atomic<std::uint32_t> done{0};  ///< the number of samples that this side has published or taken
  sem_t go{};

  Report() { sem_init(&go, 1, 0); }
};
using NodeProcess = NodeProcessWith<Report>;

/// Publishes whenever the test posts `go`. The wait for this post takes one wake-up and one system call.
void publish(Node& node, Report& report, Reliability reliability) {
  auto publisher = node.publisher<PointCloud2>("points", {.reliability = reliability}).value();
  report.served = publisher.wait_for_subscribers(1, 30s);
  report.process = getpid();
  for (std::uint32_t number = 1;; ++number) {
    while (sem_wait(&report.go) != 0) {
    }
    publisher.publish({.height = number});
    report.done = number;
  }
}

void subscribe(Node& node, Report& report, Reliability reliability) {
  const auto count = [&](const auto& sample) { report.done = sample->height(); };
  const auto subscriber =
      node.subscriber<PointCloud2, F::height>("points", count, {.reliability = reliability}).value();
  report.process = getpid();
  for (;;) pause();
}

bool sleeps(const std::filesystem::path& task) {
  std::string line;
  std::getline(std::ifstream(task / "stat"), line);
  const std::size_t behind_name = line.rfind(')');
  return behind_name != std::string::npos && line.substr(behind_name + 1).starts_with(" S");
}

bool all_sleep(pid_t process) {
  const std::filesystem::directory_iterator tasks("/proc/" + std::to_string(process) + "/task");
  return std::ranges::all_of(tasks, [](const auto& task) { return sleeps(task.path()); });
}

/// Returns the lower quartile of the values.
std::int64_t usual(std::vector<std::int64_t> values) {
  std::ranges::sort(values);
  return values[values.size() / 4];
}

/// Returns how often the thread for slow callbacks was woken.
std::int64_t slow_calls(const std::vector<ThreadCounts>& threads) {
  const auto thread =
      std::ranges::find_if(threads, [](const ThreadCounts& one) { return one.name.starts_with("sft-call"); });
  return thread == threads.end() ? 0 : thread->counts.wake_ups;
}

/// The counts of one side, one for each sample.
struct Side {
  std::vector<std::int64_t> wake_ups, system_calls;

  void add(const Counts& of_sample) {
    wake_ups.push_back(of_sample.wake_ups);
    if (of_sample.system_calls) system_calls.push_back(*of_sample.system_calls);
  }
};

struct Variant {
  Way way;
  Reliability reliability;
  std::int64_t publisher_wake_ups_max;
  std::int64_t publisher_calls_max;
  std::int64_t subscriber_calls_max;
};

std::string variant_name(const ::testing::TestParamInfo<Variant>& variant) {
  const std::string way = variant.param.way == Way::udp ? "udp" : "udp_sockets";
  return variant.param.reliability == Reliability::reliable ? way + "_reliable" : way;
}

class ColdPathTest : public ::testing::TestWithParam<Variant> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto made = hosts::EmulatedNetwork::create(2);
    if (!made) GTEST_SKIP() << made.error().message;
    network_ = std::make_unique<hosts::EmulatedNetwork>(std::move(*made));
    const Reliability reliability = GetParam().reliability;
    publisher_ = start(0, [reliability](Node& node, Report& report) { publish(node, report, reliability); });
    subscriber_ =
        start(1, [reliability](Node& node, Report& report) { subscribe(node, report, reliability); });
    ASSERT_TRUE(
        eventually([&] { return publisher_->report().process != 0 && subscriber_->report().process != 0; }));
    ASSERT_TRUE(publisher_->report().served);
    pass_one();  // the first sample needs more work
  }

  void pass_samples() {
    const ProcessCounter publishing(publisher_->report().process), subscribing(subscriber_->report().process);
    why_no_calls_ = publishing.uncountable();
    for (std::size_t i = 0; i < samples_max && subscriber_side_.wake_ups.size() < samples; ++i) {
      const auto published = publishing.read(), arrived = subscribing.read();
      pass_one();
      const auto published_now = publishing.read(), arrived_now = subscribing.read();
      if (slow_calls(arrived_now) != slow_calls(arrived)) continue;
      publisher_side_.add(sum_of(published_now).since(sum_of(published)));
      subscriber_side_.add(sum_of(arrived_now).since(sum_of(arrived)));
    }
    ASSERT_EQ(subscriber_side_.wake_ups.size(), samples)
        << "a thread of their own called nearly all callbacks";
  }
  bool has_system_calls() const { return publisher_side_.system_calls.size() == samples; }

  Side publisher_side_, subscriber_side_;
  std::vector<std::string> why_no_calls_;

 private:
  std::unique_ptr<NodeProcess> start(std::size_t host, const NodeProcess::Role& role) {
    return std::make_unique<NodeProcess>(network_->host(host), node_options(GetParam().way, "cold"), role);
  }
  void pass_one() {
    Report &from = publisher_->report(), &to = subscriber_->report();
    sem_post(&from.go);
    ++passed_;
    ASSERT_TRUE(eventually([&] {
      return from.done == passed_ && to.done == passed_ && all_sleep(from.process) && all_sleep(to.process);
    }));
  }

  std::unique_ptr<hosts::EmulatedNetwork> network_;
  std::unique_ptr<NodeProcess> publisher_, subscriber_;
  std::uint32_t passed_ = 0;
};

TEST_P(ColdPathTest, ASmallSampleWakesNoThreadButThoseThatPublishAndReceiveIt) {
  pass_samples();
  EXPECT_LE(usual(publisher_side_.wake_ups), GetParam().publisher_wake_ups_max);
  EXPECT_LE(usual(subscriber_side_.wake_ups), 1);
}

TEST_P(ColdPathTest, ASmallSampleTakesFewSystemCalls) {
  pass_samples();
  if (!has_system_calls()) GTEST_SKIP() << ::testing::PrintToString(why_no_calls_);
  EXPECT_LE(usual(publisher_side_.system_calls), GetParam().publisher_calls_max);
  EXPECT_LE(usual(subscriber_side_.system_calls), GetParam().subscriber_calls_max);
}

// The sending thread may also be woken for an answer to a reliable sample.
INSTANTIATE_TEST_SUITE_P(Ways, ColdPathTest,
                         ::testing::Values(Variant{Way::udp, Reliability::best_effort, 1, 2, 1},
                                           Variant{Way::udp_sockets, Reliability::best_effort, 1, 2, 3},
                                           Variant{Way::udp, Reliability::reliable, 2, 4, 1},
                                           Variant{Way::udp_sockets, Reliability::reliable, 2, 4, 3}),
                         variant_name);

}  // namespace
}  // namespace sft::test
