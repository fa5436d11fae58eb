// The other process in tests of shared memory. The process does one task, reports the result on its standard
// output, and continues until it is killed.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "core/platform/doorbell.h"
#include "shm_transport/daemon/process_daemon.h"
#include "shm_transport/host/session.h"
#include "tests/support/pace.h"
#include "tests/support/shm_frame.h"
#include "tests/transports/shm/shm_fixture.h"
#include "tests/transports/shm/stepped_peer.h"

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

/// The pause between two samples, for tasks that do not run as fast as they can.
constexpr std::chrono::microseconds pause{200};

/// Publishes frames with `data` bytes of data without a pause.
void publish(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  say("publishing");
  for (;;) writer.send_frame(data);
}

void publish_paced(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  say("publishing");
  for (sft::test::Pace pace(pause);; pace.await_turn()) writer.send_frame(data);
}

/// Takes 16 chunks and keeps them. Half of the chunks are loans. The other half are sent and kept, as a
/// history keeps samples.
void hoard(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  std::vector<SampleHandle> loans(16);
  for (SampleHandle& loan : loans) loan = writer.loan(data);
  for (std::size_t i = 0; i < 8; ++i) writer.send(loans[i], data);
  say("hoarded");
  stay();
}

/// Calls hoard(), after it has forked a process that does nothing but keep all sockets and memory of this
/// process.
void hoard_with_a_worker(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  if (fork() == 0) {
    alarm(60);
    stay();
  }
  hoard(node, id, data);
}

/// Takes samples, and holds the last few of them.
class Taker {
 public:
  Taker(Node& node, sft::core::EndpointId id) : reader_(node) {
    if (!reader_.connects_to(id)) say("cannot connect");
    say("subscribed");
  }
  void take() {
    if (SampleHandle sample = reader_.take()) held_[taken_++ % held_.size()] = std::move(sample);
  }

 private:
  Reader reader_;
  std::array<SampleHandle, 4> held_;
  std::size_t taken_ = 0;
};

void subscribe(Node& node, sft::core::EndpointId id, std::uint32_t) {
  for (Taker taker(node, id);;) taker.take();
}

void subscribe_paced(Node& node, sft::core::EndpointId id, std::uint32_t) {
  Taker taker(node, id);
  for (sft::test::Pace pace(pause);; pace.await_turn()) taker.take();
}

/// Takes a sample and gives it back, each time the parent continues the process.
void take_by_steps(Node& node, sft::core::EndpointId id, std::uint32_t depth) {
  Reader reader(node, depth);
  if (!reader.connects_to(id)) say("cannot connect");
  sft::test::let_parent_step();
  say("subscribed");
  for (sft::test::mark();; sft::test::mark()) {
    sft::test::mark();
    reader.take();
  }
}

/// Sends a sample each time the parent continues the process.
void send_by_steps(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Writer writer(node, id);
  sft::test::let_parent_step();
  say("publishing");
  for (sft::test::mark();; sft::test::mark()) {
    const SampleHandle sample = writer.loan(data);
    sft::test::mark();
    writer.send(sample, data);
  }
}

long minor_faults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_minflt;
}

/// Takes one sample, reads its two scalars and then its data. Reports the number of pages that each of the
/// two steps touched.
void count_faults(Node& node, sft::core::EndpointId id, std::uint32_t data) {
  Reader reader(node);
  if (!reader.connects_to(id)) say("cannot connect");
  reader.take();  // a first call touches pages of the functions themselves, which must not count
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

std::byte* target = nullptr;

/// Reads a sample, tries to write to the sample, and reports which of the two was possible.
void try_to_write(Node& node, sft::core::EndpointId id, std::uint32_t) {
  Reader reader(node);
  if (!reader.connects_to(id)) say("cannot connect");
  const SampleHandle sample = reader.next();
  if (!sample) say("no sample");
  signal(SIGSEGV, [](int) {
    constexpr char text[] = "cannot write\n";
    _exit(write(1, text, sizeof text - 1) > 0 ? 0 : 1);
  });
  target = sample->data;
  say("reads " + std::to_string(field_of(*sample, 1)));
  *const_cast<volatile std::byte*>(target) = std::byte{1};
  say("wrote");
}

/// Opens a port to publish, or reports why that is impossible.
void offer(Node& node, sft::core::EndpointId id, std::uint32_t) {
  const auto port = node->open_writer({.id = id, .type = &frame_type()});
  say(port ? "may publish" : port.error().message);
  stay();
}

/// Opens a reader with a doorbell of its own, and prints the id of the doorbell's page.
void listen(Node& node, sft::core::EndpointId, std::uint32_t) {
  const auto page = sft::core::DoorbellPage::create();
  const auto port = node->open_reader({.id = 7, .type = &frame_type(), .doorbell = {page->id(), 0}});
  say(port ? std::to_string(page->id()) : port.error().message);
  stay();
}

/// Sends a sample to a reader with a doorbell in this page, or reports why the reader cannot be woken.
void ring(Node& node, sft::core::EndpointId page, std::uint32_t) {
  Writer writer(node, 1);
  const sft::core::Route route{
      .reader = 7, .destination = sft::core::DoorbellAddress{page, 0}, .selection = frame_type().full()};
  const std::string why_not = writer.port().why_unreachable(route);
  writer.port().set_routes({route});
  const bool sent = writer.send_frame() == sft::core::SendStatus::sent;
  say(why_not.empty() && sent ? "rang" : why_not);
}

/// Reports why the transport cannot be used, as soon as that is known, or "not refused".
int knock(Node& node) {
  const bool refused = node.becomes(Availability::unavailable, std::chrono::seconds(2));
  say(refused ? node->description() : "not refused");
  return 0;
}

/// Locks a port of its own, as a writer does for the instructions in which it delivers.
void lock(Node&, sft::core::EndpointId id, std::uint32_t) {
  const auto session = sft::shm::ProcessDaemon::shared()->advance(own_daemon(), Clock::now()).session;
  const auto port = session->create_publisher(id, {hang_timeout, hang_timeout});
  if (port) (*port)->m_chunkSenderData.lock();
  say(port ? "locked" : port.error().message);
  stay();
}

/// Reports that the node is ready, and waits until the process is killed.
void attend(Node&, sft::core::EndpointId, std::uint32_t) {
  say("ready");
  stay();
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, void (*)(Node&, sft::core::EndpointId, std::uint32_t)> tasks{
      {"publish", publish},
      {"publish-paced", publish_paced},
      {"hoard", hoard},
      {"hoard-with-a-worker", hoard_with_a_worker},
      {"subscribe", subscribe},
      {"subscribe-paced", subscribe_paced},
      {"take-by-steps", take_by_steps},
      {"send-by-steps", send_by_steps},
      {"count-faults", count_faults},
      {"try-to-write", try_to_write},
      {"offer", offer},
      {"listen", listen},
      {"ring", ring},
      {"lock", lock},
      {"attend", attend}};
  const std::string wanted = argc > 1 ? argv[1] : "";
  const auto task = tasks.find(wanted);
  if (task == tasks.end() && wanted != "knock") return 2;
  Node node;
  if (wanted == "knock") return knock(node);
  const bool own = wanted == "attend" && argc > 2;
  const auto longest = own ? std::chrono::seconds(std::strtol(argv[2], nullptr, 10)) : hang_timeout;
  if (!node.becomes(Availability::ready, longest)) {
    say("not ready: " + node->description());
    return 1;
  }
  task->second(node, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0,
               argc > 3 ? static_cast<std::uint32_t>(std::strtoul(argv[3], nullptr, 10)) : 100);
}
