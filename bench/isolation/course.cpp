#include "bench/isolation/course.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "bench/common/pair.h"
#include "bench/isolation/pipeline.h"

namespace sft::bench::isolation {

namespace {

constexpr double timeout_s = 20;
constexpr double recovery_s = 2;
constexpr std::int64_t warm_up_us = 1'000'000;
constexpr std::int64_t straggling_us = 500'000;  // the time to wait for late messages

struct Watched {
  Phase phase;
  Numbers numbers;
  Resources resources;
};

constexpr int lossy_percent = 20;
constexpr int narrow_mbit_s = 50;

void check(const Result<void>& done) {
  if (done) return;
  std::fprintf(stderr, "the link of the remote reader cannot be changed: %s\n", done.error().message.c_str());
  std::exit(1);
}

/// The link of the remote reader's host. Its quality can be degraded. Ends the program with a message if
/// the system refuses that.
class Link {
 public:
  Link(std::shared_ptr<const hosts::EmulatedNetwork> network, std::size_t host)
      : network_(std::move(network)), host_(host) {}

  /// Makes the host lose `lossy_percent` of the arriving packets, chosen at random (nftables).
  void make_lossy() const;
  /// Limits the traffic from the switch to the host to `narrow_mbit_s` Mbit/s. The switch queues 50 ms of
  /// traffic, and drops further packets (the token bucket filter of tc).
  void make_narrow() const;
  // The following functions undo these changes.
  void lose_nothing() const;
  void widen() const;

 private:
  const std::shared_ptr<const hosts::EmulatedNetwork> network_;
  const std::size_t host_;
};

void Link::make_lossy() const {
  check(network_->host(host_).run({"nft", "-f", "-"},
                                  fmt::format("table netdev loss {{\n"
                                              "  chain arriving {{\n"
                                              "    type filter hook ingress device {} priority 0;\n"
                                              "    numgen random mod 100 < {} drop\n"
                                              "  }}\n"
                                              "}}\n",
                                              hosts::host_interface, lossy_percent)));
}

void Link::lose_nothing() const {
  check(network_->host(host_).run({"nft", "delete", "table", "netdev", "loss"}));
}

void Link::make_narrow() const {
  check(network_->run_on_switch({"tc", "qdisc", "add", "dev", hosts::EmulatedNetwork::port(host_), "root",
                                 "tbf", "rate", fmt::format("{}mbit", narrow_mbit_s), "burst", "16kb",
                                 "latency", "50ms"}));
}

void Link::widen() const {
  check(network_->run_on_switch({"tc", "qdisc", "del", "dev", hosts::EmulatedNetwork::port(host_), "root"}));
}

/// Changes the remote reader, or its link, as each phase requires.
class Remote {
 public:
  Remote(Pipeline& pipeline, Link link) : pipeline_(pipeline), link_(std::move(link)) {}

  void begin(Phase phase) {
    if (phase == Phase::joined) pipeline_.start_remote();
    if (phase == Phase::stalled) pipeline_.signal_remote(SIGSTOP);
    if (phase == Phase::lossy) link_.make_lossy();
    if (phase == Phase::narrow) link_.make_narrow();
    if (phase == Phase::killed) pipeline_.signal_remote(SIGKILL);
  }

  /// Restores normal conditions, except after the reader was killed. Then waits at most recovery_s until the
  /// reader gets new messages.
  void end(Phase phase) {
    if (phase == Phase::alone || phase == Phase::again || phase == Phase::killed) return;
    if (phase == Phase::joined) warn_if_missing();
    if (phase == Phase::stalled) pipeline_.signal_remote(SIGCONT);
    if (phase == Phase::lossy) link_.lose_nothing();
    if (phase == Phase::narrow) link_.widen();
    const std::uint64_t before = pipeline_.board().written.load();
    wait_until([&] { return pipeline_.board().remote_latest.load() > before; }, recovery_s);
  }

 private:
  void warn_if_missing() const {
    if (!pipeline_.board().remote_matched.load())
      std::fprintf(stderr, "  the remote reader was not matched in the phase in which it joined\n");
  }

  Pipeline& pipeline_;
  const Link link_;
};

Resources since(const Resources& before, const Resources& now) {
  return {now.s - before.s, now.local_cpu_s - before.local_cpu_s, now.remote_cpu_s - before.remote_cpu_s};
}

Watched watch(Pipeline& pipeline, Remote& remote, Phase phase, double phase_s) {
  const std::uint64_t first = pipeline.board().written.load() + 1;
  const Resources before = pipeline.resources();
  remote.begin(phase);
  sleep_us(static_cast<std::int64_t>(phase_s * 1e6));
  const Watched seen{
      phase, {first, pipeline.board().written.load() + 1}, since(before, pipeline.resources())};
  remote.end(phase);
  return seen;
}

}  // namespace

void run_course(const Contender& contender, const std::shared_ptr<const hosts::EmulatedNetwork>& network,
                const Scale& scale, Results& results) {
  Pipeline pipeline(contender, network, scale.rate_hz);
  if (!wait_until([&] { return pipeline.is_ready(); }, timeout_s)) {
    std::fprintf(stderr, "%s: the programs of one host did not find each other\n",
                 name_of(contender).c_str());
    return;
  }
  pipeline.begin();
  sleep_us(warm_up_us);
  Remote remote(pipeline, Link(network, Pipeline::remote_host));
  std::vector<Watched> all;
  for (const Phase phase : all_phases) all.push_back(watch(pipeline, remote, phase, scale.phase_s));
  sleep_us(straggling_us);
  for (const Watched& seen : all)
    results.add(contender, seen.phase, observe(pipeline.board(), seen.numbers, seen.resources));
}

}  // namespace sft::bench::isolation
