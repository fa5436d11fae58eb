// The other process in tests: does one thing, says so on its standard output, and goes on until it is killed.
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "frame.h"
#include "shm_fixture.h"

namespace {

using namespace sft::test;
using sft::core::Availability;
using sft::core::SampleHandle;

void say(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

[[noreturn]] void stay() {
  for (;;) pause();
}

/// Publishes frames of that much data without a pause.
void publish(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  say("publishing");
  for (;;) writer.send_frame(data);
}

/// Takes 16 chunks and keeps them: half on loan, half sent, as a history would.
void hoard(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  std::vector<SampleHandle> loans(16);
  for (SampleHandle& loan : loans) loan = writer.loan(data);
  for (std::size_t i = 0; i < 8; ++i) writer.send(loans[i], data);
  say("hoarded");
  stay();
}

/// Takes samples without a pause, and always holds the last few.
void subscribe(Node& node, sft::core::EndpointId id, std::uint32_t) {
  Reader reader(node);
  if (!reader.connects_to(id)) say("cannot connect");
  say("subscribed");
  std::vector<SampleHandle> held(4);
  for (std::size_t i = 0;;) {
    if (SampleHandle sample = reader.take()) held[i++ % held.size()] = std::move(sample);
  }
}

long minor_faults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

/// Takes one sample, reads its two scalars and then its data; says how many pages each touched.
void count_faults(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Reader reader(node);
  if (!reader.connects_to(id)) say("cannot connect");
  reader.take();  // what the first call of anything touches
  minor_faults();
  say("subscribed");
  SampleHandle sample;
  while (!sample) {
    const long before = minor_faults();
    sample = reader.take();
    if (!sample) continue;
    const std::uint32_t sum = field_of(*sample, 0) + field_of(*sample, 1);
    const long scalars = minor_faults() - before;
    unsigned total = 0;
    for (std::uint32_t i = 0; i < data; i += 4096) total += static_cast<unsigned>(data_of(*sample)[i]);
    say(std::to_string(scalars) + " " + std::to_string(minor_faults() - before - scalars) + " " +
        std::to_string(sum) + " " + std::to_string(total));
  }
  stay();
}

/// Gets ready and stays; lets the daemon be started.
void attend(Node&, sft::core::EndpointId, std::uint32_t) {
  say("ready");
  stay();
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, void (*)(Node&, sft::core::EndpointId, std::uint32_t)> tasks{
      {"publish", publish},
      {"hoard", hoard},
      {"subscribe", subscribe},
      {"count-faults", count_faults},
      {"attend", attend}};
  const auto task = argc > 1 ? tasks.find(argv[1]) : tasks.end();
  if (task == tasks.end()) return 2;
  Node node;
  if (!node.becomes_ready()) {
    say("not ready: " + node->description());
    return 1;
  }
  task->second(node, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0,
               argc > 3 ? static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10)) : 100);
}
