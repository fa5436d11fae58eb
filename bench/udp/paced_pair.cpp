#include "bench/udp/paced_pair.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <limits>

#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/signal.h"

namespace sft::bench {

namespace {

// The time after which most of the traffic of joining is over.
constexpr std::int64_t settling_us = 1'000'000;
constexpr double timeout_s = 20;

struct Board {
  std::atomic<std::uint64_t> received{0};
  std::atomic<bool> failed{false};
  Signal matched, warm, go, over_at_sender, over_at_receiver;
};

/// Writes samples, with one system call and one sleep before each sample except the first. Returns the
/// number of samples that were at least a period late, so that no thread slept before them.
std::uint64_t write_paced(Writer& writer, std::uint64_t first, std::uint64_t count, std::int64_t period_us) {
  std::uint64_t late = 0;
  timespec due{};
  clock_gettime(CLOCK_MONOTONIC, &due);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (i > 0) {
      due.tv_nsec += period_us * 1000;
      due.tv_sec += due.tv_nsec / 1'000'000'000;
      due.tv_nsec %= 1'000'000'000;
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
      const std::int64_t due_ns = std::int64_t{due.tv_sec} * 1'000'000'000 + due.tv_nsec;
      late += now_ns() - due_ns >= period_us * 1000 ? 1 : 0;
    }
    writer.write(first + i);
  }
  return late;
}

int send(Board& board, Contender contender, const Paced& paced) {
  const auto peer = contender();
  const auto writer = peer->writer(paced.topic);
  board.matched.wait();
  if (!wait_until([&] { return writer->readers() == 1; })) board.failed = true;
  const auto samples_before = static_cast<std::uint64_t>(settling_us / paced.period_us);
  write_paced(*writer, 1, samples_before, paced.period_us);
  sleep_us(paced.period_us);
  board.warm.give();
  board.go.wait();
  const std::uint64_t late = write_paced(*writer, samples_before + 1, paced.messages, paced.period_us);
  board.over_at_sender.wait();
  if (late > 0)
    std::fprintf(stderr, "%zu of %zu samples were a period late or more, since this machine is busy\n",
                 std::size_t{late}, std::size_t{paced.messages});
  return 0;
}

int receive(Board& board, Contender contender, const Topic& topic) {
  const auto peer = contender();
  const auto reader = peer->reader(topic, [&](std::uint64_t) { ++board.received; });
  while (reader->writers() == 0) sleep_us(1000);
  board.matched.give();
  board.over_at_receiver.wait();
  return 0;
}

}  // namespace

bool pass_paced(Contender contender, const Paced& paced, const TwoHosts& hosts,
                const std::function<void(const PacedPair&)>& begin,
                const std::function<void(const PacedPair&)>& end) {
  const Shared<Board> board;
  const pid_t receiver = start_on_core(1, [&] {
    hosts.enter(1);
    return receive(*board, contender, paced.topic);
  });
  const pid_t sender = start_on_core(0, [&] {
    hosts.enter(0);
    return send(*board, contender, paced);
  });
  bool passed = board->warm.comes(timeout_s) && !board->failed;
  if (passed) {
    const std::uint64_t all = board->received + paced.messages;
    begin({sender, receiver});
    board->go.give();
    sleep_us(static_cast<std::int64_t>(std::max<std::uint64_t>(paced.messages, 1)) * paced.period_us);
    passed = wait_until([&] { return board->received >= all; }, 2);
    end({sender, receiver});
  }
  if (!passed) {
    kill(sender, SIGKILL);
    kill(receiver, SIGKILL);
  }
  board->over_at_sender.give();
  board->over_at_receiver.give();
  const bool sent = succeeds(sender);
  return succeeds(receiver) && sent && passed;
}

}  // namespace sft::bench
