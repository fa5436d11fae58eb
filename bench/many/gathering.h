// A publisher and its readers. Each is a node in a process of its own. They start together, and keep
// running.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cstdio>

#include "bench/common/host_processes.h"
#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/many/members.h"

namespace sft::bench {

class Gathering {
 public:
  Gathering(const Member& member, std::size_t readers, std::size_t hosts)
      : member_(member), readers_(readers), processes_(hosts), begin_ns_(now_ns()) {
    processes_.start(0, [&] { return be_writer(); });
    for (std::size_t i = 0; i < readers; ++i)
      processes_.start(processes_.host_of_reader(i), [&] { return be_reader(); });
  }

  /// Waits until all nodes are matched. If the timeout ends first, reports that on the standard error and
  /// returns false.
  bool wait(double timeout_s) {
    if (!wait_until([&] { return board_->matched.load() == readers_ + 1; }, timeout_s)) {
      std::fprintf(stderr, "%s: %zu of %zu nodes were matched after %.0f s\n", member_.name,
                   board_->matched.load(), readers_ + 1, timeout_s);
      board_->last_ns = now_ns();
      return false;
    }
    return true;
  }
  /// Returns the time from the start until the last node was matched, or until the timeout.
  double seconds() const { return static_cast<double>(board_->last_ns.load() - begin_ns_) / 1e9; }
  const HostProcesses& processes() const { return processes_; }

 private:
  static constexpr std::int64_t pause_us =
      5000;  // a longer pause would distort the time, and a shorter one the processor time

  struct Board {
    std::atomic<std::size_t> matched{0};
    std::atomic<std::int64_t> last_ns{0};
  };

  template <class Matched>
  int stay_when(Matched matched) const {
    while (!matched()) sleep_us(pause_us);
    board_->last_ns = now_ns();
    ++board_->matched;
    for (;;) pause();
  }
  int be_writer() const {
    const auto peer = member_.open();
    const auto writer = peer->writer(cloud_topic(0));
    return stay_when([&] { return writer->serves(readers_); });
  }
  int be_reader() const {
    const auto peer = member_.open();
    const auto reader = peer->reader(cloud_topic(0));
    return stay_when([&] { return reader->writers() == 1; });
  }

  const Member member_;
  const std::size_t readers_;
  const Shared<Board> board_;
  HostProcesses processes_;
  const std::int64_t begin_ns_;
};

}  // namespace sft::bench
