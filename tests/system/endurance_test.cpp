// Programs that live long among programs that come, go and are killed, on a network that loses frames, while
// selections change. The memory of each of them remains flat. CI runs this for some seconds, which shows only
// gross leaks. ./run soak runs it for more than an hour, and prints the figure soak_growth_mb_per_hour of
// each process.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <std_msgs/msg/String.hpp>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/daemon_status.h"
#include "tests/system/lossy_cable.h"
#include "tests/system/node_process.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using std_msgs::msg::String;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// The progress of a process.
struct Progress {
  std::atomic<bool> failed{false}, closed{false};
  std::atomic<std::uint64_t> samples{0};  ///< the samples that the process has taken so far
};
using Program = NodeProcessWith<Progress>;

// ---- the programs that live long ----

/// Publishes clouds, reliable texts and a latched text, and takes the commands of all programs that come and
/// go. Every half a minute, it publishes twenty large clouds at once.
void be_robot(Node& node, Progress& progress) {
  auto points = node.publisher<PointCloud2>("points").value();
  auto log = node.publisher<String>("log", {.reliability = reliable}).value();
  auto map =
      node.publisher<String>("map", {.reliability = reliable, .durability = Durability::transient_local})
          .value();
  auto commands = node.subscriber<String>("commands", {.reliability = reliable, .depth = 100}).value();
  map.publish({.data = std::string(20'000, 'm')});
  Clock::time_point burst = Clock::now();
  std::uint32_t number = 0;
  for (Pace pace(20ms);; pace.await_turn()) {
    const bool is_burst = Clock::now() - burst > 30s;
    if (is_burst) burst = Clock::now();
    for (int i = 0; i < (is_burst ? 20 : 1); ++i) {
      auto loan = points.loan({.height = ++number, .width = 1}, {.data = is_burst ? 2'000'000U : 60'000U});
      if (loan) std::move(*loan).publish();
    }
    if (number % 10 == 0) log.publish({.data = "at " + std::to_string(number)});
    while (commands.take()) ++progress.samples;
  }
}

/// Takes what the robot publishes. The selection changes every second.
void be_consumer(Node& node, Progress& progress) {
  auto points = node.subscriber<PointCloud2>("points", {.selection = "height"}).value();
  auto log = node.subscriber<String>("log", {.reliability = reliable, .depth = 100}).value();
  Clock::time_point changed = Clock::now();
  for (std::uint64_t round = 0;;) {
    points.wait(20ms);
    while (points.take()) ++progress.samples;
    while (log.take()) ++progress.samples;
    if (Clock::now() - changed < 1s) continue;
    changed = Clock::now();
    const std::string end = std::to_string(1 + ++round % 50'000);
    (void)points.set_selection(round % 2 == 0 ? "height" : "width, data[:" + end + "]");
  }
}

/// Reads other fields in each minute, and so SFT records other fields.
void be_recording_consumer(Node& node, Progress& progress) {
  auto points = node.subscriber<PointCloud2>("points").value();
  for (const auto start = Clock::now();;) {
    points.wait(1s);
    while (auto cloud = points.take()) {
      ++progress.samples;
      if ((Clock::now() - start) / 1min % 2 == 0)
        (void)cloud->width();
      else
        (void)cloud->header().frame_id();
    }
  }
}

// ---- the programs that come and go ----

/// Subscribes to two topics, publishes commands, and closes its node after some samples.
void be_visitor(Node& node, Progress& progress) {
  {
    auto points = node.subscriber<PointCloud2>("points", {.selection = "height, data[:100]"}).value();
    auto map =
        node.subscriber<String>("map", {.reliability = reliable, .durability = Durability::transient_local})
            .value();
    auto commands = node.publisher<String>("commands", {.reliability = reliable}).value();
    for (int i = 0; i < 10; ++i) {
      if (points.wait(100ms) && points.take()) ++progress.samples;
      while (map.take()) ++progress.samples;
      commands.publish({.data = "stop"});
    }
  }
  { const Node closes = std::move(node); }
  progress.closed = true;
  for (;;) pause();
}

/// Returns the memory that the process shares with no other process.
std::int64_t private_bytes(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return std::stol(line.substr(8)) * 1024;
  return 0;
}

/// The memory of one process early and late in the test: the least and the most of each time. A peak of the
/// load takes memory for a while. What does not come back raises the least.
struct Memory {
  struct Range {
    std::int64_t least = std::numeric_limits<std::int64_t>::max(), most = 0;

    void note(std::int64_t bytes) {
      least = std::min(least, bytes);
      most = std::max(most, bytes);
    }
  };
  std::string name;
  pid_t process;
  Range early{}, late{};
};

class Endurance : public RandomTest {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto cable = LossyCable::create({.loss = 0.02}, random());
    if (!cable) GTEST_SKIP() << cable.error().message;
    cable_ = std::move(*cable);
    begin("robot", 0, be_robot);
    ASSERT_TRUE(cable_->host(0).enter());  // The daemon answers only on its own host.
    ASSERT_TRUE(eventually([] { return daemon_status().contains("pid"); }, hang_timeout, 100ms))
        << "the daemon does not run";
    memories_.push_back({"sftd", daemon_status().at("pid")});
    begin("consumer_of_robot", 0, be_consumer);
    begin("remote_consumer", 1, be_consumer);
    begin("recording_consumer", 1, be_recording_consumer);
    for (const auto& program : programs_)
      ASSERT_TRUE(eventually([&] { return program->report().samples > 0 || program == programs_.front(); }));
  }

  std::unique_ptr<Program> program(const std::string& name, std::size_t host,
                                   const Program::Role& role) const {
    NodeOptions options{.name = name};
    // The hosts share one /dev/shm. So shared memory is only for one of them.
    options.transport = host == 0 ? TransportChoice::automatic : TransportChoice::udp;
    options.log = [](LogLevel, std::string_view) {};  // The cable makes losses, which the log would name.
    return std::make_unique<Program>(cable_->host(host), options, role);
  }
  void begin(const std::string& name, std::size_t host, const Program::Role& role) {
    programs_.push_back(program(name, host, role));
    memories_.push_back({name, programs_.back()->id()});
  }

  /// One visitor comes. Half of the visitors are killed at a random moment, and the others close their node.
  void be_visited(std::uint64_t number) {
    cable_->become(number / 5 % 2 == 1);
    const auto visitor = program("visitor_" + std::to_string(number % 7), random() % 2, be_visitor);
    const bool is_killed = random() % 2 == 0;
    const std::chrono::milliseconds life(is_killed ? random() % 1000 : hang_timeout / 1ms);
    const bool has_closed = eventually([&] { return visitor->report().closed.load(); }, life, 10ms);
    EXPECT_TRUE(has_closed || is_killed) << "a visitor does not end";
    visits_heard_ += visitor->report().samples > 0 ? 1 : 0;
  }
  void look(Memory::Range Memory::*when) {
    for (Memory& memory : memories_) (memory.*when).note(private_bytes(memory.process));
  }

  std::unique_ptr<LossyCable> cable_;
  std::vector<std::unique_ptr<Program>> programs_;
  std::vector<Memory> memories_;
  std::uint64_t visits_heard_ = 0;
};

TEST_F(Endurance, NoProgramThatLivesLongGrows) {
  const std::uint64_t rounds = test_rounds(14);
  const std::uint64_t warm_up = rounds / 7, window = rounds / 7;
  Clock::time_point early, late;
  for (std::uint64_t round = 0; round < rounds && !HasFailure(); ++round) {
    be_visited(round);
    if (round >= warm_up && round < warm_up + window) {
      look(&Memory::early);
      early = Clock::now();
    }
    if (round >= rounds - window) look(&Memory::late);
  }
  late = Clock::now();

  const double hours = std::chrono::duration<double>(late - early).count() / 3600;
  // In a short run, the first samples of each kind still take memory.
  const double allowed_mb = hours < 0.5 ? 16 : 2 * hours;
  for (const Memory& memory : memories_) {
    const double grown_mb = static_cast<double>(memory.late.least - memory.early.least) / 1e6;
    std::printf(
        "soak_growth_mb_per_hour of %s: %.2f (%.1f to %.1f MB, and %.1f to %.1f MB after %.2f hours)\n",
        memory.name.c_str(), grown_mb / hours, static_cast<double>(memory.early.least) / 1e6,
        static_cast<double>(memory.early.most) / 1e6, static_cast<double>(memory.late.least) / 1e6,
        static_cast<double>(memory.late.most) / 1e6, hours);
    EXPECT_GT(memory.late.least, 0) << memory.name << " has ended";
    EXPECT_LE(grown_mb, allowed_mb) << memory.name;
  }
  for (const auto& program : programs_) EXPECT_FALSE(program->report().failed);
  EXPECT_GT(visits_heard_, rounds / 4) << "too few visitors were served";
}

}  // namespace
}  // namespace sft::test
