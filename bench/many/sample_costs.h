// Measures what a sample costs that a publisher sends many readers: bytes that leave the publisher's host,
// processor time, and latency. The bytes of the same nodes without samples are taken off; the processor time
// is all that they took.
#pragma once

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "bench/common/crowd.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/signal.h"
#include "bench/common/statistics.h"
#include "bench/many/members.h"
#include "bench/many/settling.h"

namespace sft::bench {

struct Case {
  std::size_t readers;
  std::size_t hosts;
  Payload payload;
  std::vector<Fields> phases;  ///< what the same readers ask for, one after the other
  double settling_s;  ///< for which samples are sent until the bytes settle; 0: it does not wait for that
  std::uint64_t samples;
  std::int64_t period_us;
  std::int64_t calm_us = 1'000'000;  ///< a time in which discovery sends next to nothing is a sign of its end
  std::uint64_t warming = 0;         ///< samples that do not count
};

/// The costs of a sample.
struct Costs {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double bytes = unknown;
  double publisher_cpu_us = unknown;
  double subscriber_cpu_us = unknown;
  double latency_us = unknown;  ///< the median of all samples at all readers
  double settled_ms = unknown;
};

/// One case with one contender. It begins at once, and goes on until wait().
template <class Member>
class SampleCosts {
 public:
  explicit SampleCosts(const Case& of) : phases_(of.phases.size()), crowd_(of.hosts) {
    crowd_.start(0, [&] { return Publishing(*board_, of).run(); });
    for (std::size_t i = 0; i < of.readers; ++i)
      crowd_.start(crowd_.host_of_reader(i), [&, i] { return read(*board_, of, i); });
  }

  /// The costs of each phase.
  std::vector<Costs> wait() {
    if (!crowd_.first_succeeds()) std::fprintf(stderr, "%s: not all readers were served\n", Member::name);
    return {board_->costs.begin(), board_->costs.begin() + static_cast<std::ptrdiff_t>(phases_)};
  }

 private:
  static constexpr std::size_t readers_max = 64, phases_max = 4, arrivals_max = 16'384;
  static constexpr double joining_s = 90;

  struct Board {
    std::atomic<std::size_t> knowing{0};       ///< readers' nodes that know the publisher
    std::array<Signal, readers_max> go;        ///< a reader begins the next phase
    std::atomic<std::size_t> matched{0};       ///< readers, in all phases together
    std::atomic<std::int64_t> sent_ns{0};      ///< when the last sample was sent
    std::atomic<std::uint64_t> received{0};    ///< samples that all readers together have received
    std::array<double, arrivals_max> us = {};  ///< that each of them took, in a ring
    std::array<pid_t, readers_max> readers = {};
    std::array<Costs, phases_max> costs;

    void note_arrival() {
      const std::int64_t ns = now_ns() - sent_ns;
      us[received++ % arrivals_max] = static_cast<double>(ns) / 1000;
    }
  };

  /// The resources that were used so far.
  struct Used {
    double s = 0, bytes = 0, publisher_s = 0, readers_s = 0;

    Used operator-(const Used& before) const {
      return {s - before.s, bytes - before.bytes, publisher_s - before.publisher_s,
              readers_s - before.readers_s};
    }
  };

  class Publishing {
   public:
    Publishing(Board& board, const Case& of) : board_(board), case_(of) {}

    int run() {
      if (!wait_until([&] { return board_.knowing.load() == case_.readers; }, joining_s)) return 1;
      wait_for_calm();
      for (std::size_t phase = 0; phase < case_.phases.size(); ++phase) {
        matched_ = (phase + 1) * case_.readers;
        costs_ = &board_.costs[phase];
        for (std::size_t i = 0; i < case_.readers; ++i) board_.go[i].give();
        if (case_.settling_s > 0 ? !settle() : !wait_until([&] { return all_matched(); }, joining_s))
          return 1;
        send(case_.warming);
        measure();
      }
      return 0;
    }

   private:
    static constexpr std::int64_t settling_period_us = 20'000;
    static constexpr std::int64_t calm_bytes_per_s = 50'000;
    static constexpr double calming_s = 20;
    static constexpr double arriving_at_least = 0.95;  // of all samples, since the network loses none
    static constexpr double arriving_s = 0.2;          // after which a sample is lost
    static constexpr double arriving_reliably_s = 20;

    bool all_matched() const { return board_.matched.load() == matched_ && writer_.serves(case_.readers); }

    /// Waits until discovery is over, as far as its traffic shows.
    void wait_for_calm() const {
      const std::int64_t end = now_ns() + static_cast<std::int64_t>(calming_s * 1e9);
      while (now_ns() < end) {
        const LinkBytes before = link_bytes();
        sleep_us(case_.calm_us);
        const LinkBytes now = link_bytes();
        if (now.received - before.received + now.sent - before.sent <
            calm_bytes_per_s * case_.calm_us / 1'000'000)
          return;
      }
    }

    /// Publishes while readers come, and for a while after that.
    bool settle() {
      std::vector<Counted> samples;
      const std::int64_t begin = now_ns();
      std::int64_t matched_ns = 0, end = begin + static_cast<std::int64_t>(joining_s * 1e9);
      while (now_ns() < end) {
        samples.push_back({now_ns(), link_bytes().sent});
        writer_.write();
        sleep_us(settling_period_us);
        if (matched_ns != 0 || !all_matched()) continue;
        matched_ns = now_ns();
        end = matched_ns + static_cast<std::int64_t>(case_.settling_s * 1e9);
      }
      costs_->settled_ms = settled_ms(samples, matched_ns);
      return matched_ns != 0;
    }

    /// A sample waits until the one before has arrived.
    void send(std::uint64_t samples) {
      const double patience_s = case_.payload.reliable ? arriving_reliably_s : arriving_s;
      for (std::uint64_t i = 0; i < samples; ++i) {
        const std::uint64_t all = board_.received + case_.readers;
        board_.sent_ns = now_ns();
        writer_.write();
        sleep_us(case_.period_us);
        wait_until([&] { return board_.received >= all; }, patience_s);
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
      for (std::uint64_t i = received; i < board_.received; ++i) us.push_back(board_.us[i % arrivals_max]);
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
        std::fprintf(stderr, "%s: %.0f of %.0f samples arrived\n", Member::name, received, samples * readers);
        return;
      }
      costs_->bytes = (sending.bytes - quiet_bytes) / samples;
      costs_->publisher_cpu_us = 1e6 * sending.publisher_s / samples;
      costs_->subscriber_cpu_us = 1e6 * sending.readers_s / samples / readers;
      costs_->latency_us = median_if_any(us_since(received_before));
    }

    Board& board_;
    const Case& case_;
    std::size_t matched_ = 0;  ///< the board's count when all readers of this phase are matched
    Costs* costs_ = nullptr;   ///< of this phase
    Member member_;
    typename Member::Writer writer_{member_, case_.payload};
  };

  static int read(Board& board, const Case& of, std::size_t number) {
    Member member;
    member.know_publisher();
    board.readers[number] = getpid();
    ++board.knowing;
    std::optional<typename Member::MaskedReader> reader;
    for (const Fields& fields : of.phases) {
      board.go[number].wait();
      if (!reader) reader.emplace(member, of.payload, [&] { board.note_arrival(); });
      reader->ask_for(fields(number));
      while (!reader->matched()) sleep_us(5000);
      ++board.matched;
    }
    for (;;) pause();
  }

  const std::size_t phases_;
  const Shared<Board> board_;
  Crowd crowd_;
};

}  // namespace sft::bench
