// Our side in shared memory, for samples of two sizes: what a reader of `width` waits for must not depend on
// the data.
#include <sft/sft.h>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/statistics.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr std::uint32_t large = 6'291'456;
constexpr std::uint32_t small = 16;

NodeOptions options(const char* name) { return {.name = name, .transport = TransportChoice::shm}; }

void send(Exchange& exchange, std::uint64_t messages, std::uint32_t bytes, std::int64_t pause) {
  Node node = Node::open(options("sender")).value();
  auto publisher = node.publisher<PointCloud2>("spine").value();
  while (publisher.status().readers.empty() || !publisher.status().readers[0].served) pause_us(1000);
  const PointCloud2 prototype;
  for (std::uint64_t i = 0; i < messages; ++i) {
    pause_us(pause);
    auto loan = publisher.loan_for_overwrite(prototype, {.data = bytes}).value();
    loan.set(F::width, static_cast<std::uint32_t>(i + 1));
    exchange.sent_at[i] = now_ns();
    std::move(loan).publish();
    if (!exchange.wait_for_receipt(i + 1)) {
      exchange.failed = true;
      return;
    }
  }
}

void receive(Exchange& exchange, std::uint64_t messages, bool asleep) {
  Node node = Node::open(options("receiver")).value();
  auto subscriber = node.subscriber<PointCloud2, F::width>("spine").value();
  for (std::uint64_t next = 1; next <= messages && !exchange.failed;) {
    if (asleep) subscriber.wait(std::chrono::seconds(1));
    const auto sample = subscriber.take();
    if (!sample) continue;
    const std::uint64_t number = sample->width();
    exchange.received_at[number - 1] = now_ns();
    exchange.received.store(number, std::memory_order_release);
    next = number + 1;
  }
}

double p50(std::uint64_t messages, std::uint32_t bytes, bool asleep) {
  auto times = run_pair({.sender = [=](Exchange& e) { send(e, messages, bytes, asleep ? 150 : 5); },
                         .receiver = [=](Exchange& e) { receive(e, messages, asleep); }},
                        messages);
  return quantile(times, 0.5);
}

}  // namespace

std::vector<Figure> shared_memory(const Scale& scale) {
  std::vector<double> sleeping, sleeping_small, spinning, spinning_small, waitset, polling;
  for (int round = 0; round < scale.rounds; ++round) {
    sleeping.push_back(p50(scale.messages, large, true));
    auto raw = raw_iceoryx_waitset(scale.messages);
    waitset.push_back(quantile(raw, 0.5));
    sleeping_small.push_back(p50(scale.messages, small, true));
    spinning.push_back(p50(scale.messages, large, false));
    raw = raw_iceoryx_polling(scale.messages);
    polling.push_back(quantile(raw, 0.5));
    spinning_small.push_back(p50(scale.messages, small, false));
  }
  return {
      {"shm_sleeping", median(sleeping), "us", median(waitset), "iceoryx WaitSet, 16 B", 1.3},
      {"shm_spinning", median(spinning), "us", median(polling), "iceoryx polling, 16 B", 2.0},
      {"shm_sleeping_size", median(sleeping), "us", median(sleeping_small), "the same, 16 B of data", {}},
      {"shm_spinning_size", median(spinning), "us", median(spinning_small), "the same, 16 B of data", {}}};
}

}  // namespace sft::bench
