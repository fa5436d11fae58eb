#include "bench/udp/stream.h"

#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <limits>
#include <numeric>

#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"

namespace sft::bench {

namespace {

constexpr double warm_up_s = 0.2;
constexpr std::int64_t quiet_us = 300'000;  // if no sample arrives for this time, no more will arrive

struct Moment {
  std::int64_t at_ns = 0;
  std::uint64_t received = 0;
  double cpu_s = 0;
};

struct Board {
  alignas(64) std::atomic<std::uint64_t> received{0};
  alignas(64) std::atomic<pid_t> receiver{0};
  std::atomic<bool> over{false};
  // The moments at which the measured time begins and ends.
  Moment begin, end;
  std::uint64_t lost = 0;

  Moment moment() const { return {now_ns(), received.load(), cpu_s(getpid()) + cpu_s(receiver.load())}; }
};

void receive(Board& board, Contender contender, const Topic& topic) {
  const auto peer = contender();
  const auto reader =
      peer->reader(topic, [&](std::uint64_t) { board.received.fetch_add(1, std::memory_order_relaxed); });
  while (reader->writers() == 0) sleep_us(1000);
  board.receiver = getpid();
  while (!board.over.load()) sleep_us(5000);
}

class Sender {
 public:
  Sender(Board& board, Writer& writer, const Load& load) : board_(board), writer_(writer), load_(load) {}

  void send_for(double seconds) {
    const std::int64_t until = now_ns() + static_cast<std::int64_t>(seconds * 1e9);
    while (now_ns() < until) {
      if (load_.together == 1) {
        writer_.write(sent_ + 1);
      } else {
        writer_.write_together(sent_ + 1, load_.together);
      }
      sent_ += load_.together;
    }
  }
  /// Returns the number of samples that never arrived.
  std::uint64_t count_lost() const {
    for (std::uint64_t before = ~0ull; before != board_.received && board_.received < sent_;) {
      before = board_.received;
      sleep_us(quiet_us);
    }
    return sent_ - std::min<std::uint64_t>(sent_, board_.received);
  }

 private:
  Board& board_;
  Writer& writer_;
  const Load& load_;
  std::uint64_t sent_ = 0;
};

int send(Board& board, Contender contender, const Load& load) {
  const auto peer = contender();
  const auto writer = peer->writer(load.topic);
  if (!wait_until([&] { return board.receiver.load() != 0 && writer->readers() == 1; })) return 1;
  Sender sender(board, *writer, load);
  sender.send_for(warm_up_s);
  board.begin = board.moment();
  sender.send_for(load.seconds);
  board.end = board.moment();
  board.lost = sender.count_lost();
  board.over = true;
  return 0;
}

}  // namespace

void StreamRounds::run(Contender contender, const Load& load, const TwoHosts& hosts) {
  const Shared<Board> board;
  const pid_t receiver = start_on_core(1, [&] {
    hosts.enter(1);
    receive(*board, contender, load.topic);
    return 0;
  });
  const bool sent = succeeds(start_on_core(0, [&] {
    hosts.enter(0);
    return send(*board, contender, load);
  }));
  if (!sent) kill(receiver, SIGKILL);
  const auto received = static_cast<double>(board->end.received - board->begin.received);
  if (!succeeds(receiver) || !sent || received == 0) return;
  samples_per_s_.push_back(received / (static_cast<double>(board->end.at_ns - board->begin.at_ns) / 1e9));
  cpu_s_per_sample_.push_back((board->end.cpu_s - board->begin.cpu_s) / received);
  lost_.push_back(static_cast<double>(board->lost));
}

double StreamRounds::samples_per_s() const { return median_if_any(samples_per_s_); }
double StreamRounds::cpu_s_per_sample() const { return median_if_any(cpu_s_per_sample_); }
double StreamRounds::lost() const {
  if (lost_.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(lost_.begin(), lost_.end(), 0.);
}

}  // namespace sft::bench
