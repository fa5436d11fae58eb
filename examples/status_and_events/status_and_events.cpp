// status_and_events [json]: shows how a program observes its publishers and subscribers. Events report
// changes; status() and snapshot() return the present state.
#include <sft/sft.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <std_msgs/msg/Float64.hpp>
#include <thread>

using namespace std::chrono_literals;
using std_msgs::msg::Float64;

std::atomic<int> deadlines_missed{0};

/// Events are reported on a thread of the node, which can report no further event until the callback
/// returns. So a callback must return quickly.
sft::Event::Callback print_events_of(const char* whose) {
  return [whose](const sft::Event& event) {
    if (event.kind == sft::Event::Kind::deadline_missed) ++deadlines_missed;
    std::printf("%s: %s (%s)\n", whose, to_string(event.kind), event.text.c_str());
  };
}

int main(int argc, char**) {
  sft::NodeOptions options{.name = "status_and_events"};
  // The log reports the same events as lines of text, if they have at least this level.
  options.log_level = sft::LogLevel::warning;
  options.log = [](sft::LogLevel, std::string_view line) { std::cout << "log: " << line << std::endl; };
  auto node = sft::Node::open(options);
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;

  auto speed =
      node->publisher<Float64>("speed", {.deadline = 200ms, .on_event = print_events_of("publisher")});
  const auto show = [](const auto& sample) { std::printf("display: %.1f m/s\n", sample->data()); };
  auto display =
      node->subscriber<Float64>("speed", show, {.deadline = 200ms, .on_event = print_events_of("display")});
  // The publisher does not offer the reliability that this subscriber requests. So the two never match, and
  // both get an event that names the reason.
  auto recorder = node->subscriber<Float64>(
      "speed", {.reliability = sft::reliable, .on_event = print_events_of("recorder")});
  if (!speed || !display || !recorder) return std::puts("a publisher or subscriber could not be opened"), 1;

  speed->wait_for_subscribers(1, 5s);
  for (int i = 0; i < 10; ++i) {
    speed->publish({.data = 0.1 * i});
    std::this_thread::sleep_for(50ms);
  }
  // Now nothing is published for longer than the deadline, and both sides get an event.
  for (int i = 0; i < 500 && deadlines_missed < 2; ++i) std::this_thread::sleep_for(10ms);

  for (const sft::PublisherStatus::Reader& reader : speed->status().readers) {
    std::printf("reader: %s, %lu sent: %s\n", reader.served ? to_string(reader.transport) : "not served",
                reader.sent, reader.reason.c_str());
  }
  std::printf("display: %lu received, %lu lost\n", display->status().received, display->status().lost);
  if (argc > 1) std::cout << to_json(node->snapshot()) << std::endl;  // all that the node knows, as JSON
}
