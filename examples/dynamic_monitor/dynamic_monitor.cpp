// dynamic_monitor TOPIC [FIELDS [COUNT]]: prints fields of any topic as YAML. It is compiled without any
// message type: publishers announce the types of their topics.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

using namespace std::chrono_literals;

int main(int argc, char** argv) {
  auto node = sft::Node::open({.name = "dynamic_monitor"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  if (argc < 2) return std::fprintf(stderr, "usage: %s TOPIC [FIELDS [COUNT]]\n", argv[0]), 1;
  const char* fields = argc > 2 ? argv[2] : "*";
  int wanted = argc > 3 ? std::atoi(argv[3]) : 1'000'000;

  // Waits for a publisher. If there is none, the error lists the existing topics.
  const auto type = node->find_type(argv[1], 10s);
  if (!type) return std::fprintf(stderr, "%s\n", type.error().message.c_str()), 1;
  std::printf("# %s is a %s\n", argv[1], std::string(type->name()).c_str());

  // Fields are text: "header.stamp, fields[].name". The error says what is wrong with the text.
  auto topic = node->subscriber(argv[1], *type, fields);
  if (!topic) return std::fprintf(stderr, "%s\n", topic.error().message.c_str()), 1;
  while (wanted > 0 && topic->wait(10s)) {
    while (const auto sample = topic->take()) {
      std::printf("%s---\n", sample.to_yaml().value().c_str());
      // Reads a single field by its name. An absent field is an error, never zero.
      const auto width = sample.view()["width"].as<int>();
      if (width && *width > 1000) std::printf("# a wide cloud: %d\n", *width);
      --wanted;
    }
  }
}
