#include "bench/many/sample_costs.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <numeric>

#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/statistics.h"
#include "bench/many/settling.h"

namespace sft::bench {

namespace {

using Board = SampleCosts::Board;

constexpr double joining_s = 90;

Topic topic_of(const Case& of) {
  Topic topic = of.topic;
  topic.readers = of.readers;
  return topic;
}

/// The resources that have been used up to a moment.
struct Used {
  double s = 0, bytes = 0, publisher_s = 0, readers_s = 0;

  Used operator-(const Used& before) const {
    return {s - before.s, bytes - before.bytes, publisher_s - before.publisher_s,
            readers_s - before.readers_s};
  }
};

class Publishing {
 public:
  Publishing(Board& board, const Member& member, const Case& of)
      : board_(board),
        case_(of),
        name_(member.name),
        peer_(member.open()),
        writer_(peer_->writer(topic_of(of))) {}

  int run() {
    if (!wait_until([&] { return board_.knowing.load() == case_.readers; }, joining_s)) return 1;
    wait_until_settled();
    for (std::size_t i = 0; i < case_.readers; ++i) board_.go[i].give();
    if (!settle()) return 1;
    measure();
    return 0;
  }

 private:
  static constexpr std::int64_t quiet_us = 1'000'000;
  static constexpr std::int64_t settling_period_us = 20'000;
  static constexpr std::int64_t settled_bytes_per_s = 50'000;
  static constexpr double calming_s = 20;
  // Required share of arriving samples; the network itself loses none.
  static constexpr double arriving_at_least = 0.95;
  static constexpr double arriving_s = 0.2;  // a sample counts as lost after this time

  bool all_matched() const {
    return board_.matched.load() == case_.readers && writer_->serves(case_.readers);
  }

  /// Waits until discovery has ended, which its traffic shows.
  void wait_until_settled() const {
    const std::int64_t end = now_ns() + static_cast<std::int64_t>(calming_s * 1e9);
    while (now_ns() < end) {
      const LinkBytes before = link_bytes();
      sleep_us(quiet_us);
      const LinkBytes now = link_bytes();
      if (now.received - before.received + now.sent - before.sent <
          settled_bytes_per_s * quiet_us / 1'000'000)
        return;
    }
  }

  /// Publishes while readers match, and for a while after that.
  bool settle() {
    std::vector<Counted> samples;
    const std::int64_t begin = now_ns();
    std::int64_t matched_ns = 0, end = begin + static_cast<std::int64_t>(joining_s * 1e9);
    while (now_ns() < end) {
      samples.push_back({now_ns(), link_bytes().sent});
      writer_->write(0);
      sleep_us(settling_period_us);
      if (matched_ns != 0 || !all_matched()) continue;
      matched_ns = now_ns();
      end = matched_ns + static_cast<std::int64_t>(case_.settling_s * 1e9);
    }
    board_.costs.settled_ms = settled_ms(samples, matched_ns);
    return matched_ns != 0;
  }

  /// Sends samples one by one. Each waits until the previous one has arrived.
  void send(std::uint64_t samples) {
    for (std::uint64_t i = 0; i < samples; ++i) {
      const std::uint64_t all = board_.received + case_.readers;
      board_.sent_ns = now_ns();
      writer_->write(0);
      sleep_us(case_.period_us);
      wait_until([&] { return board_.received >= all; }, arriving_s);
    }
  }

  Used used() const {
    const auto readers_s = std::accumulate(
        board_.readers.begin(), board_.readers.begin() + static_cast<std::ptrdiff_t>(case_.readers), 0.,
        [](double sum, pid_t reader) { return sum + cpu_s(reader); });
    return {static_cast<double>(now_ns()) / 1e9, static_cast<double>(link_bytes().sent), cpu_s(getpid()),
            readers_s};
  }

  std::vector<double> us_since(std::uint64_t received) const {
    std::vector<double> us;
    for (std::uint64_t i = received; i < board_.received; ++i)
      us.push_back(board_.us[i % SampleCosts::arrivals_max]);
    return us;
  }

  void measure() {
    const std::uint64_t received_before = board_.received;
    const Used begin = used();
    send(case_.samples);
    const Used sending = used() - begin;
    const auto received = static_cast<double>(board_.received - received_before);
    const std::int64_t quiet_before = link_bytes().sent;
    sleep_us(static_cast<std::int64_t>(sending.s * 1e6));
    const auto quiet_bytes = static_cast<double>(link_bytes().sent - quiet_before);
    const auto samples = static_cast<double>(case_.samples), readers = static_cast<double>(case_.readers);
    if (received < arriving_at_least * samples * readers) {
      std::fprintf(stderr, "%s: %.0f of %.0f samples arrived\n", name_, received, samples * readers);
      return;
    }
    board_.costs.bytes = (sending.bytes - quiet_bytes) / samples;
    board_.costs.publisher_cpu_us = 1e6 * sending.publisher_s / samples;
    board_.costs.subscriber_cpu_us = 1e6 * sending.readers_s / samples / readers;
    board_.costs.latency_us = median_if_any(us_since(received_before));
  }

  Board& board_;
  const Case& case_;
  const char* const name_;
  const std::unique_ptr<Peer> peer_;
  const std::unique_ptr<Writer> writer_;
};

int read(Board& board, const Member& member, const Case& of, std::size_t number) {
  const auto peer = member.open();
  peer->know_writer(of.topic);
  board.readers[number] = getpid();
  ++board.knowing;
  board.go[number].wait();
  Topic topic = of.topic;
  topic.wanted.fields = of.fields(number);
  const auto reader = peer->reader(topic, [&](std::uint64_t) { board.note_arrival(); });
  while (reader->writers() != 1) sleep_us(5000);
  ++board.matched;
  for (;;) pause();
}

}  // namespace

SampleCosts::SampleCosts(const Member& member, const Case& of) : member_(member), processes_(of.hosts) {
  processes_.start(0, [&] { return Publishing(*board_, member, of).run(); });
  for (std::size_t i = 0; i < of.readers; ++i)
    processes_.start(processes_.host_of_reader(i), [&, i] { return read(*board_, member, of, i); });
}

Costs SampleCosts::wait() {
  if (!processes_.first_succeeds()) std::fprintf(stderr, "%s: not all readers were served\n", member_.name);
  return board_->costs;
}

}  // namespace sft::bench
