// Prints fields of any topic as JSON, without its type: dashboard TOPIC FIELDS.
#include <sft/sft.h>
#include <chrono>
#include <cstdio>

using namespace std::chrono_literals;

int main(int argc, char** argv) {
  if (argc != 3) return std::puts("dashboard TOPIC FIELDS"), 2;
  sft::Node node = sft::Node::open({.name = "dashboard", .transport = sft::TransportChoice::udp}).value();
  const auto type = node.find_type(argv[1], 10s);
  if (!type) return std::fprintf(stderr, "%s\n", type.error().message.c_str()), 1;
  auto topic = node.subscriber(argv[1], *type, argv[2]);
  if (!topic) return std::fprintf(stderr, "%s\n", topic.error().message.c_str()), 1;
  for (int i = 0; i < 3 && topic->wait(5s);) {
    while (const auto sample = topic->take()) {
      std::printf("%s\n", sample.to_json().value().c_str());
      ++i;
    }
  }
  const sft::SubscriberStatus status = topic->status();
  std::printf("%lu received, %lu lost\n", status.received, status.lost);
}
