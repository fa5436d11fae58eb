#include <sft/sft.h>
#include <sys/resource.h>

#include <atomic>
#include <memory>
#include <sensor_msgs/msg/BatteryState.hpp>
#include <string>
#include <thread>

#include "bench/common/contest.h"
#include "bench/common/node_options.h"
#include "bench/common/pair.h"
#include "bench/selection/selection.h"
#include "core/seam/gate.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::BatteryState;
using namespace std::chrono_literals;

constexpr double bound_ns = 30;  ///< the bound of the time per gate and sample

/// Returns a gate that has evaluated the message once, and does not let it pass again.
std::unique_ptr<core::Gate> closed_gate(const std::string& conditions, const BatteryState& message) {
  const TypeSupport& type = type_support<BatteryState>();
  const Selection selection = type.parse_selection("* @ " + conditions).value();
  auto gate = std::make_unique<core::Gate>(0, detail::Conditions(type.type(), selection.gate().conditions),
                                           selection.gate_hash());
  gate->reader_begins();
  gate->consider(detail::FieldSource::of_message(&message), 0);
  gate->made(detail::FieldSource::of_message(&message), 0);
  return gate;
}

Figure time_of(std::string name, const std::string& conditions, int rounds) {
  BatteryState message;
  message.voltage = 11.1F;
  message.percentage = 0.5F;
  const auto gate = closed_gate(conditions, message);
  const auto best = best_times_ns(
      {batch_of([&] { gate->consider(detail::FieldSource::of_message(&message), 1); })}, rounds);
  return {std::move(name), best[0], "ns", bound_ns, "the bound, for " + conditions, 1.0};
}

/// Returns the number of times that a thread that waits for samples in shared memory is woken while
/// `samples` are published, none of which has more than 1 V. The last sample, of 5 V, wakes the thread once
/// more. That wake-up is not counted.
double wakeups(const std::string& selection, int samples) {
  Node a = Node::open(node_options("publisher", TransportChoice::shm)).value();
  Node b = Node::open(node_options("subscriber", TransportChoice::shm)).value();
  auto publisher = a.publisher<BatteryState>("battery").value();
  SubscriberOptions options{.spin = 0ns};
  options.selection = selection;
  auto subscriber = b.subscriber<BatteryState>("battery", options).value();
  wait_until([&] {
    const auto readers = publisher.status().readers;
    return !readers.empty() && readers[0].served;
  });
  BatteryState message;
  message.voltage = 5;
  publisher.publish(message);
  while (!subscriber.take()) subscriber.wait(1s);
  message.voltage = 0;
  long switches = 0;
  std::atomic<bool> is_ready{false};
  std::thread reader([&] {
    const auto now = [] {
      rusage usage{};
      getrusage(RUSAGE_THREAD, &usage);
      return usage.ru_nvcsw;
    };
    const long before = now();
    is_ready = true;
    for (bool is_last = false; !is_last && subscriber.wait(60s);) {
      while (const auto sample = subscriber.take()) is_last = sample->voltage() > 1;
    }
    switches = now() - before;
  });
  wait_until([&] { return is_ready.load(); });
  for (int i = 0; i < samples; ++i) {
    sleep_us(200);
    publisher.publish(message);
  }
  sleep_us(200);
  message.voltage = 5;
  publisher.publish(message);
  reader.join();
  return static_cast<double>(switches - 1);
}

}  // namespace

std::vector<Figure> closed_gates(int rounds, int samples) {
  const double open = wakeups("", samples);
  const double closed = wakeups("@ voltage > 1", samples);
  return {time_of("gate_closed", "voltage > 20", rounds),
          time_of("gate_closed_changed", "changed(voltage) 1 %", rounds),
          time_of("gate_closed_several", "changed(voltage, current, percentage) 1 % or every 10 s", rounds),
          {"gate_closed_wakeups", closed, "", {}, "", 0.0},
          {"gate_open_wakeups", open, "", static_cast<double>(samples), "samples", {}}};
}

}  // namespace sft::bench
