#include "bench/isolation/course.h"

#include <csignal>
#include <cstdio>
#include <vector>

#include "bench/common/pair.h"
#include "bench/isolation/link.h"
#include "bench/isolation/pipeline.h"

namespace sft::bench::isolation {

namespace {

constexpr double patience_s = 20;
constexpr double recovery_s = 2;
constexpr std::int64_t warm_up_us = 1'000'000;
constexpr std::int64_t straggling_us = 500'000;  // for messages that arrive late

struct Watched {
  Phase phase;
  Numbers numbers;
  Resources resources;
};

/// What happens to the remote reader.
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

  /// Makes all well again, apart from death, and waits for a while until the reader gets new messages.
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
  if (!wait_until([&] { return pipeline.is_ready(); }, patience_s)) {
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
