#include "bench/many/gathering.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

constexpr double joining_s = 60;

struct Idle {
  Tally received, sent, cpu_percent, resident_mb, anonymous_mb;
};

/// The costs of a group of processes up to a moment.
struct Moment {
  explicit Moment(const HostProcesses& processes)
      : at_ns(now_ns()), link(processes.link_bytes()), cpu_s(processes.cpu_s()) {}

  std::int64_t at_ns;
  LinkBytes link;
  double cpu_s;
};

void note(const HostProcesses& processes, const Moment& before, void (Tally::*add)(double), Idle& idle) {
  const Moment now(processes);
  const double seconds = static_cast<double>(now.at_ns - before.at_ns) / 1e9;
  const auto nodes = static_cast<double>(processes.size());
  const auto per_s = [&](std::int64_t bytes) { return static_cast<double>(bytes) / seconds; };
  (idle.received.*add)(per_s(now.link.received - before.link.received) /
                       static_cast<double>(processes.hosts()));
  (idle.sent.*add)(per_s(now.link.sent - before.link.sent) / nodes);
  (idle.cpu_percent.*add)(100 * (now.cpu_s - before.cpu_s) / seconds / nodes);
  (idle.resident_mb.*add)(processes.resident_bytes() / 1e6 / nodes);
  (idle.anonymous_mb.*add)(processes.anonymous_bytes() / 1e6 / nodes);
}

}  // namespace

/// Measures all groups of processes in the same seconds. That is possible because idle processes hardly use
/// the processors.
std::vector<Figure> idle(const ManyScale& scale) {
  Gathering ours(sft_member, 31, emulated_hosts);
  bool matched = ours.wait(joining_s);
  Gathering theirs(cyclone_member, 31, emulated_hosts);
  matched = theirs.wait(joining_s) && matched;
  Gathering our_two(sft_member, 1, 1);
  matched = our_two.wait(joining_s) && matched;
  Gathering their_two(cyclone_member, 1, 1);
  matched = their_two.wait(joining_s) && matched;
  sleep_us(static_cast<std::int64_t>(scale.settled_s * 1e6));
  Idle of_32, of_2;
  for (int round = 0; round < scale.rounds && matched; ++round) {
    const Moment our_begin(ours.processes()), their_begin(theirs.processes());
    const Moment our_two_begin(our_two.processes()), their_two_begin(their_two.processes());
    sleep_us(static_cast<std::int64_t>(scale.window_s * 1e6));
    note(ours.processes(), our_begin, &Tally::add_ours, of_32);
    note(theirs.processes(), their_begin, &Tally::add_reference, of_32);
    note(our_two.processes(), our_two_begin, &Tally::add_ours, of_2);
    note(their_two.processes(), their_two_begin, &Tally::add_reference, of_2);
  }
  const std::string who = cyclone_member.name;
  return {of_32.received.figure("idle_32_received", "B/s", who + ", by each host", 1.2),
          of_32.sent.figure("idle_32_sent", "B/s", who + ", by each node", 1.2),
          of_32.cpu_percent.figure("idle_32_cpu", "%", who + ", by each node", 1.2),
          of_32.resident_mb.figure("idle_32_rss", "MB", who + ", of each node", 1.2),
          of_32.anonymous_mb.figure("idle_32_anonymous", "MB", who + ", of each node", 1.2),
          of_2.sent.figure_with_bound_of_value("idle_2_sent", "B/s", who + ", by each node", 150)};
}

}  // namespace sft::bench
