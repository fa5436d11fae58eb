#include "bench/many/gathering.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

constexpr std::size_t readers = 64;

struct Joining {
  Tally time_s, megabytes, cpu_s;
};

/// Runs the nodes and adds the figures. If not all nodes are matched in time, the figures cover only the
/// time before the limit, and complete figures would be larger.
void run(const Member& member, const ManyScale& scale, void (Tally::*add)(double), Joining& joining) {
  Gathering gathering(member, readers, emulated_hosts);
  gathering.wait(scale.joining_s);
  (joining.megabytes.*add)(static_cast<double>(gathering.processes().link_bytes().sent) / 1e6);
  (joining.cpu_s.*add)(gathering.processes().cpu_s());
  (joining.time_s.*add)(gathering.seconds());
}

}  // namespace

std::vector<Figure> join_64(const ManyScale& scale) {
  Joining joining;
  for (int round = 0; round < scale.rounds; ++round) {
    run(sft_member, scale, &Tally::add_ours, joining);
    run(cyclone_member, scale, &Tally::add_reference, joining);
  }
  return {joining.time_s.figure("join_64_time", "s", cyclone_member.name, 1.3),
          joining.megabytes.figure("join_64_bytes", "MB", cyclone_member.name, 1.3),
          joining.cpu_s.figure("join_64_cpu", "s", cyclone_member.name, 1.3)};
}

}  // namespace sft::bench
