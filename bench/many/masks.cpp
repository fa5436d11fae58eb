// Measures what readers with different masks cost: bytes that leave the publisher's host, and processor time.
// The bytes of the same nodes without samples are taken off; the processor time is all that they took.
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <numeric>

#include "bench/common/cloud_masks.h"
#include "bench/common/crowd.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/many/many.h"
#include "bench/many/members.h"
#include "bench/many/settling.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

constexpr std::size_t data_bytes = 16'000;
constexpr std::size_t readers_max = 64;
constexpr double joining_s = 90;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double arriving_at_least = 0.95;  // of all samples, since the network loses none

struct Case {
  std::size_t readers;
  std::size_t hosts;
  Fields fields;
  double settling_s;  ///< for which samples are sent before those that count; 0: the first one counts
  std::uint64_t samples;
  std::int64_t period_us;
};

/// The costs of a sample.
struct Costs {
  double bytes = unknown;
  double publisher_cpu_us = unknown;
  double subscriber_cpu_us = unknown;
  double settled_ms = unknown;
};

struct Board {
  std::atomic<std::size_t> knowing{0};  ///< readers' nodes that know the publisher
  std::atomic<bool> go{false};          ///< readers begin
  std::atomic<std::size_t> matched{0};
  std::atomic<std::uint64_t> received{0};  ///< samples that all readers together have received
  pid_t readers[readers_max] = {};
  Costs costs;
};

/// The resources that were used so far.
struct Used {
  double s = 0, bytes = 0, publisher_s = 0, readers_s = 0;

  Used operator-(const Used& before) const {
    return {s - before.s, bytes - before.bytes, publisher_s - before.publisher_s,
            readers_s - before.readers_s};
  }
};

template <class Member>
class Publishing {
 public:
  Publishing(Board& board, const Case& of) : board_(board), case_(of) {}

  int run() {
    if (!wait_until([&] { return board_.knowing.load() == case_.readers; }, joining_s)) return 1;
    wait_for_calm();
    board_.go = true;
    if (case_.settling_s > 0 ? !settle() : !wait_until([&] { return all_matched(); }, joining_s)) return 1;
    measure();
    return 0;
  }

 private:
  static constexpr std::int64_t settling_period_us = 20'000;
  static constexpr std::int64_t calm_bytes_per_s = 50'000;
  static constexpr int patience_s = 20;

  bool all_matched() const { return board_.matched.load() == case_.readers && writer_.serves(case_.readers); }

  /// Waits until discovery is over, as far as its traffic shows.
  static void wait_for_calm() {
    for (int second = 0; second < patience_s; ++second) {
      const LinkBytes before = link_bytes();
      sleep_us(1'000'000);
      const LinkBytes now = link_bytes();
      if (now.received - before.received + now.sent - before.sent < calm_bytes_per_s) return;
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
    board_.costs.settled_ms = settled_ms(samples, matched_ns);
    return matched_ns != 0;
  }

  Used used() const {
    const auto readers_s = std::accumulate(board_.readers, board_.readers + case_.readers, 0.,
                                           [](double sum, pid_t reader) { return sum + cpu_s(reader); });
    return {static_cast<double>(now_ns()) / 1e9, static_cast<double>(link_bytes().sent), cpu_s(getpid()),
            readers_s};
  }

  void measure() {
    const std::uint64_t received_before = board_.received;
    const Used begin = used();
    for (std::uint64_t i = 0; i < case_.samples; ++i) {
      writer_.write();
      sleep_us(case_.period_us);
    }
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
    board_.costs.bytes = (sending.bytes - quiet_bytes) / samples;
    board_.costs.publisher_cpu_us = 1e6 * sending.publisher_s / samples;
    board_.costs.subscriber_cpu_us = 1e6 * sending.readers_s / samples / readers;
  }

  Board& board_;
  const Case& case_;
  Member member_;
  typename Member::Writer writer_{member_, data_bytes};
};

template <class Member>
int read(Board& board, const Case& of, std::size_t number) {
  Member member;
  member.know_publisher();
  board.readers[number] = getpid();
  ++board.knowing;
  while (!board.go.load()) sleep_us(5000);
  const typename Member::MaskedReader reader(member, of.fields(number), [&] { ++board.received; });
  while (!reader.matched()) sleep_us(5000);
  ++board.matched;
  for (;;) pause();
}

/// Begins at once, and goes on until wait().
template <class Member>
class Run {
 public:
  explicit Run(const Case& of) : crowd_(of.hosts) {
    crowd_.start(0, [&] { return Publishing<Member>(*board_, of).run(); });
    for (std::size_t i = 0; i < of.readers; ++i)
      crowd_.start(crowd_.host_of_reader(i), [&, i] { return read<Member>(*board_, of, i); });
  }

  Costs wait() {
    if (!crowd_.first_succeeds()) std::fprintf(stderr, "%s: not all readers were served\n", Member::name);
    return board_->costs;
  }

 private:
  const Shared<Board> board_;
  Crowd crowd_;
};

struct Tallies {
  Tally bytes, publisher_cpu, subscriber_cpu, settled;

  void run(const Case& of, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      note(Run<SftMember>(of).wait(), &Tally::add_ours);
      note(Run<CycloneMember>(of).wait(), &Tally::add_reference);
    }
  }
  /// Runs both contenders at the same time, which bytes do not depend on.
  void run_for_bytes(const Case& of, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      Run<SftMember> ours(of);
      Run<CycloneMember> theirs(of);
      note(ours.wait(), &Tally::add_ours);
      note(theirs.wait(), &Tally::add_reference);
    }
  }

 private:
  void note(const Costs& costs, void (Tally::*add)(double)) {
    (bytes.*add)(costs.bytes);
    (publisher_cpu.*add)(costs.publisher_cpu_us);
    (subscriber_cpu.*add)(costs.subscriber_cpu_us);
    (settled.*add)(costs.settled_ms);
  }
};

Case many_masks(std::size_t readers, const ManyScale& scale) {
  return {.readers = readers,
          .hosts = crowd_hosts,
          .fields = own_fields_and_data,
          .settling_s = scale.quick ? 1.5 : 6.,
          .samples = scale.quick ? std::uint64_t{30} : 100,
          .period_us = 50'000};
}

/// Returns the fields that a map, a display and a monitor may need. Two of them need the data, and all of
/// them together need nearly the whole cloud.
std::string fields_of_three(std::size_t number) {
  const char* fields[] = {"header, fields, point_step, data", "header.stamp, height, width, row_step, data",
                          "height, width"};
  return fields[number];
}

constexpr const char* multicast = "Cyclone DDS, multicast";

}  // namespace

std::vector<Figure> masks_16(const ManyScale& scale) {
  Tallies tallies;
  tallies.run_for_bytes(many_masks(16, scale), scale.rounds);
  return {tallies.bytes.figure("bytes_masks_16", "B", multicast, 1.05)};
}

std::vector<Figure> masks_64(const ManyScale& scale) {
  Tallies tallies;
  tallies.run(many_masks(64, scale), scale.rounds);
  return {tallies.bytes.figure("bytes_masks_64", "B", multicast, 1.05),
          tallies.settled.figure_with_bound_of_value("settled_ms", "ms", multicast, 100),
          tallies.publisher_cpu.figure("publisher_cpu_masks_64", "us", multicast, 1),
          tallies.subscriber_cpu.figure("subscriber_cpu_64", "us", multicast, 1.1)};
}

std::vector<Figure> three_masks(const ManyScale& scale) {
  Tallies tallies;
  const Case three{.readers = 3,
                   .hosts = 3,
                   .fields = fields_of_three,
                   .settling_s = 0,
                   .samples = scale.quick ? std::uint64_t{20} : 100,
                   .period_us = 100'000};
  tallies.run_for_bytes(three, scale.rounds);
  return {tallies.bytes.figure("bytes_paper_three", "B", multicast, 1.02)};
}

}  // namespace sft::bench
