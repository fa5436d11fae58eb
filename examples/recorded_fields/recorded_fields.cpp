// No fields are declared here. SFT records which fields the callback reads, and soon sends only these. When
// the callback begins to read a further field, that field is absent from the present sample, but is sent
// with later samples.
#include <sft/sft.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <nav_msgs/msg/Odometry.hpp>
#include <thread>

using namespace std::chrono_literals;
using nav_msgs::msg::Odometry;
using Reader = sft::Subscriber<Odometry, sft::recorded>;

void print_request(const char* when, const Reader& reader) {
  std::printf("%s it asks for:", when);
  std::size_t fields = 0;
  const sft::Requirements seen = reader.requirements();
  for (const sft::Requirements::Field& field : seen.fields) {
    if (field.requested && ++fields <= 3) std::printf(" %s", field.path.c_str());
  }
  std::printf(fields > 3 ? " and %zu more\n" : "\n", fields - 3);
}

int main() {
  auto node = sft::Node::open({.name = "recorded_fields"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto odometry = node->publisher<Odometry>("odometry").value();

  std::atomic<bool> looks_at_position{false};
  const auto callback = [&](const auto& sample) {
    // Each getter returns a std::optional, which is empty if the sample does not have the field.
    if (const auto speed = sample->twist().twist().linear().x(); !speed) std::puts("no speed in this sample");
    if (!looks_at_position) return;
    const auto x = sample->pose().pose().position().x();
    x ? std::printf("position %.1f m\n", *x) : std::puts("no position in this sample");
  };
  // On one host a sample in shared memory has every field. `as_remote` reduces it to the fields that another
  // host would receive.
  auto reader =
      node->subscriber<Odometry, sft::recorded>("odometry", callback, {.recording = {.as_remote = true}})
          .value();

  print_request("At first", reader);
  odometry.wait_for_subscribers(1, 5s);
  Odometry message;
  for (int i = 0; i < 20; ++i) {
    if (i == 10) print_request("After 10 samples", reader);
    looks_at_position = i >= 10;
    message.pose.pose.position.x = 0.1 * i;
    odometry.publish(message);
    std::this_thread::sleep_for(50ms);
  }
  print_request("In the end", reader);
}
