// Measures by how much the intervals between samples of `sft play` differ from those in the recording.
#include <sft/sft.h>
#include <chrono>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>

#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/statistics.h"
#include "bench/tools/programs.h"
#include "bench/tools/tools.h"
#include "tests/support/temporary_directory.h"
#include "tools/recording/mcap_writer.h"

namespace sft::bench {

namespace {

using namespace std::chrono_literals;

constexpr double jitter_ms = 1;
constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t begin_ns = 1'700'000'000'000 * ms;
constexpr std::size_t each = 20;  // numbers between two large messages

/// A topic of the recording.
struct TopicOfRecording {
  const char* topic;
  const char* type;
  const char* definition;

  DynamicType parsed() const { return from_msg(type, definition).value(); }
};
constexpr TopicOfRecording numbers{"numbers", "sft_bench/msg/Number", "uint64 data\n"};
constexpr TopicOfRecording bulk{"bulk", "sft_bench/msg/Bytes", "uint8[] data\n"};

/// The contents of the recording: numbers with the times at which they are due, and large messages together
/// with some of the numbers.
struct Plan {
  std::vector<std::int64_t> due_ns{};
  std::vector<std::byte> large{};  ///< the encoded large message; empty: there are no large messages

  bool has_large_at(std::size_t i) const { return !large.empty() && i % each == 0; }
};

/// Returns a plan with numbers at intervals of 1 to 9 ms.
Plan plan_for(double seconds, std::uint32_t large_bytes) {
  Plan plan;
  std::minstd_rand random(1);
  for (std::int64_t due = 0; due < static_cast<std::int64_t>(seconds * 1e9);) {
    plan.due_ns.push_back(due);
    due += static_cast<std::int64_t>(1 + random() % 9) * ms;
  }
  if (large_bytes == 0) return plan;
  plan.large.resize(8 + large_bytes);
  plan.large[1] = std::byte{1};
  std::memcpy(plan.large.data() + 4, &large_bytes, sizeof large_bytes);
  return plan;
}

std::vector<std::byte> encoded(std::uint64_t number) {
  std::vector<std::byte> cdr{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  cdr.resize(4 + sizeof number);
  std::memcpy(cdr.data() + 4, &number, sizeof number);
  return cdr;
}

/// Writes the plan as a recording.
void write_recording(const Plan& plan, const std::string& path) {
  auto writer = recording::McapWriter::create(path, {}).value();
  std::uint16_t id = 0;
  for (const TopicOfRecording& one : {numbers, bulk}) {
    ++id;
    writer.declare({.id = id, .name = one.type, .encoding = "ros2msg", .data = one.definition});
    writer.declare({.id = id, .schema = id, .topic = one.topic});
  }
  for (std::size_t i = 0; i < plan.due_ns.size(); ++i) {
    const auto time = static_cast<std::uint64_t>(begin_ns + plan.due_ns[i]);
    const std::vector<std::byte> number = encoded(i);
    (void)writer.write({.channel = 1, .log_ns = time, .publish_ns = time, .data = number});
    if (plan.has_large_at(i))
      (void)writer.write({.channel = 2, .log_ns = time, .publish_ns = time, .data = plan.large});
  }
  (void)writer.close();
}

/// Publishes the same messages at the same times as `sft play` does. It is the reference.
void publish(const Plan& plan) {
  Node node = Node::open({.name = "player"}).value();
  auto small = node.publisher(numbers.topic, numbers.parsed()).value();
  auto large = node.publisher(bulk.topic, bulk.parsed()).value();
  if (!small.wait_for_subscribers(1, 20s) || !large.wait_for_subscribers(1, 20s)) return;
  const std::int64_t begin = now_ns();
  for (std::size_t i = 0; i < plan.due_ns.size(); ++i) {
    sleep_until(begin + plan.due_ns[i]);
    (void)small.publish_cdr(encoded(i));
    if (plan.has_large_at(i)) (void)large.publish_cdr(plan.large);
  }
  sleep_us(200'000);  // waits until the last number was received
}

/// Notes when each number arrives.
void receive(const Plan& plan, Exchange& exchange) {
  Node node = Node::open({.name = "reader"}).value();
  auto large = node.subscriber(bulk.topic, bulk.parsed(), "*").value();
  auto small = node.subscriber(numbers.topic, numbers.parsed(), "*", {.depth = 256}).value();
  for (std::uint64_t last = 0; last + 1 < plan.due_ns.size() && small.wait(10s);) {
    const std::int64_t now = now_ns();
    while (const auto sample = small.take()) {
      last = sample.view()["data"].as<std::uint64_t>().value();
      if (last < plan.due_ns.size()) exchange.received_at[last] = now;
    }
    while (large.take()) {
    }
  }
}

/// Returns by how much the intervals between successive numbers differ from those of the plan, in ms.
std::vector<double> jitter(const Plan& plan, const std::function<void(Exchange&)>& player) {
  const std::vector<Delivery> came =
      run_deliveries({.sender = player, .receiver = [&](Exchange& exchange) { receive(plan, exchange); }},
                     plan.due_ns.size());
  std::vector<double> differences;
  for (std::size_t i = 1; i < came.size(); ++i) {
    if (came[i].received_at == 0 || came[i - 1].received_at == 0) continue;
    const std::int64_t distance = came[i].received_at - came[i - 1].received_at;
    const std::int64_t wrong_ns = distance - (plan.due_ns[i] - plan.due_ns[i - 1]);
    differences.push_back(std::abs(static_cast<double>(wrong_ns)) / ms);
  }
  return differences;
}

Figure measured(const char* name, const Scale& scale, std::uint32_t large_bytes) {
  const test::TemporaryDirectory folder;
  const Plan plan = plan_for(scale.seconds, large_bytes);
  const std::string file = folder.path() / "run.mcap";
  write_recording(plan, file);
  Rounds played, reference;
  for (int round = 0; round < scale.rounds; ++round) {
    played.add(jitter(plan, [&](Exchange& exchange) {
      exchange.failed =
          !succeeds(start_sft(0, {"play", file, "-w", "--timeout", "20"}, folder.path() / "play.txt"));
    }));
    reference.add(jitter(plan, [&](Exchange&) { publish(plan); }));
  }
  return {.name = name,
          .value = played.p99(),
          .unit = "ms",
          .reference = reference.p99(),
          .reference_name = "a program with the same times",
          .bound = jitter_ms,
          .bound_is_of_value = true};
}

}  // namespace

std::vector<Figure> play(const Scale& scale) {
  return {measured("play_jitter_p99_ms", scale, 0),
          measured("play_jitter_beside_6.3MB_p99_ms", scale, sent_cloud_bytes)};
}

}  // namespace sft::bench
