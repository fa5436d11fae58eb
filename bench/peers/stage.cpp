#include "bench/peers/stage.h"

#include <sft/sft.h>

#include <cstdio>
#include <cstdlib>
#include <messages.hpp>

#include "bench/common/node_options.h"
#include "bench/common/process.h"
#include "bench/peers/pace.h"

namespace sft::bench::peers {

namespace {

using sft_bench::Bulk;

constexpr unsigned memory_mebibytes = 1024;  // twice the memory that sftd takes

/// Starts sftd, which continues to run after the node is closed. Returns true once sftd lends memory.
bool start_daemon() {
  Node node = Node::open(node_options("first", TransportChoice::shm)).value();
  auto publisher = node.publisher<Bulk>("first").value();
  return wait_until([&] { return publisher.loan({}, {.data = bytes_max}).has_value(); });
}

}  // namespace

Stage::Stage() : memory_(memory_mebibytes), network_(make_hosts(1 + readers_max, Trains::whole)) {
  const bool started = succeeds(start_on_core(0, [&] {
    enter(0, Way::sft_full);
    return start_daemon() ? 0 : 1;
  }));
  if (started) return;
  std::fprintf(stderr, "sftd does not start\n");
  std::exit(1);
}

void Stage::enter_as_writer(Way way) const { enter(0, way); }

void Stage::enter_as_reader(const Case& of, Way way, std::size_t reader) const {
  enter(of.where == Where::one_host ? 0 : 1 + reader, way);
}

void Stage::enter(std::size_t host, Way way) const {
  if (!network_.host(host).enter()) std::abort();
  if (way == Way::cyclone_iceoryx) roudi_.enter();
}

}  // namespace sft::bench::peers
