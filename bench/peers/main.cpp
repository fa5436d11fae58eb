// Measures SFT beside other middleware, sockets and memcpy: latency, throughput and processor time over sizes
// and readers, within one host and between hosts. Hosts are network namespaces with an MTU of 1500.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <utility>

#include "bench/common/noise.h"
#include "bench/common/program.h"
#include "bench/peers/csv.h"
#include "bench/peers/figures.h"
#include "bench/peers/tables.h"
#include "bench/peers/trial.h"
#include "tests/support/isolated_host.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::peers;

constexpr const char* how =
    "Each message starts in the program's own memory (loans: in memory that is lent, of which only two numbers\n"
    "are written). Latency is the time from publish() until the program of the last reader has the message:\n"
    "\"two fields\" has two numbers, and \"full\" all data, which SFT and iceoryx let it read in place. Delivery is\n"
    "reliable. The writer's process is pinned to core 0 with all its threads, and all readers share core 1. A\n"
    "message is sent each {} us, or when the one before has arrived. Sleeping: everybody sleeps in between; SFT\n"
    "looks for 20 us first, and with \"spin 0\" never. Spinning: the writer and the readers keep their cores busy,\n"
    "but the DDS peers, which cannot, sleep; their writer spins. CPU time is that of all processes, spinning and\n"
    "discovery included. Figures are medians of {} rounds (least to most) in turns. A p99.9 with \"w\" is the worst\n"
    "of fewer than 1000 messages. memcpy alone is the floor: one copy, without any reader.\n";

/// Leaves nothing in a buffer, of which each process that is forked later would have a copy.
void say(const std::string& text) {
  fmt::print("{}", text);
  std::fflush(stdout);
}

std::string title_of(const Case& of) {
  return std::string(of.where == Where::one_host ? "Within one host" : "Between hosts") +
         (of.waiting == Waiting::sleeping ? ", sleeping" : ", spinning");
}

/// The ids of all entrants: all of them run in this case.
std::vector<std::string> ids() {
  std::vector<std::string> ids;
  for (const Entrant& entrant : entrants({Where::one_host, Waiting::sleeping})) ids.push_back(id_of(entrant));
  return ids;
}

class Peers {
 public:
  /// One reader, all sizes.
  std::vector<Figure> sizes(Where where, Waiting waiting) {
    const Case of{where, waiting};
    measure({of}, scale.sizes, scale.pace);
    return report(title_of(of) + ", one reader", columns_of_sizes(of, scale.sizes));
  }
  /// Some sizes, several readers that sleep.
  std::vector<Figure> readers(Where where) {
    std::vector<Case> cases;
    for (const std::size_t readers : scale.readers) cases.push_back({where, Waiting::sleeping, readers});
    measure(cases, scale.sizes_of_readers, scale.pace_of_readers);
    std::vector<Figure> figures;
    for (const std::uint32_t bytes : scale.sizes_of_readers) {
      const std::string title = fmt::format("{}, several readers{}, which share one core, {}",
                                            title_of(cases.front()),
                                            where == Where::one_host ? "" : " on a host each", size_text(bytes));
      for (Figure& figure : report(title, columns_of_readers(cases.front(), scale.readers, bytes)))
        figures.push_back(std::move(figure));
    }
    return figures;
  }

  void finish() {
    write_csv(csv, records_);
    say(fmt::format("\n{}\n", noise_.text()));
  }

  Scale scale;
  std::vector<std::string> contenders;  ///< the ids of those that run; empty: all
  std::ofstream csv;

 private:
  bool runs(const Entrant& entrant) const {
    return contenders.empty() || std::ranges::find(contenders, id_of(entrant)) != contenders.end();
  }
  void measure(const std::vector<Case>& cases, const std::vector<std::uint32_t>& sizes, const Pace& pace) {
    if (stage_ == nullptr) {
      say(fmt::format(fmt::runtime(how), pace.period_us, scale.rounds));
      stage_ = std::make_unique<Stage>();
    }
    for (int round = 0; round < scale.rounds; ++round) {
      fmt::print(stderr, "  round {} of {}\n", round + 1, scale.rounds);
      for (const Case& of : cases) {
        for (const Entrant& entrant : turns(entrants(of), static_cast<std::size_t>(round))) {
          if (runs(entrant))
            add(run({of, entrant, sizes, pace}, *stage_), static_cast<std::size_t>(round));
        }
      }
    }
  }
  void add(Records records, std::size_t round) {
    for (Record& record : records) {
      record.round = round;
      records_.push_back(record);
    }
  }
  std::vector<Figure> report(const std::string& title, const std::vector<Column>& columns) const {
    say(tables(records_, title, columns) + faster_peers(records_, columns));
    return figures(records_, columns);
  }

  std::unique_ptr<Stage> stage_;
  Records records_;
  const Noise noise_{};
};

}  // namespace

int main(int argc, char** argv) {
  Peers peers;
  Program program("SFT beside other middleware, sockets and memcpy",
                  {{"intra_sleeping", [&] { return peers.sizes(Where::one_host, Waiting::sleeping); }},
                   {"intra_spinning", [&] { return peers.sizes(Where::one_host, Waiting::spinning); }},
                   {"intra_readers", [&] { return peers.readers(Where::one_host); }},
                   {"inter_sleeping", [&] { return peers.sizes(Where::two_hosts, Waiting::sleeping); }},
                   {"inter_spinning", [&] { return peers.sizes(Where::two_hosts, Waiting::spinning); }},
                   {"inter_readers", [&] { return peers.readers(Where::two_hosts); }}});
  program.leave_out_table();
  std::string csv;
  std::optional<int> rounds;
  bool quick = false;
  program.options().add_flag("--quick", quick, "one short round of fewer sizes");
  program.options().add_option("--rounds", rounds, "rounds of each contender")->check(CLI::Range(1, 100));
  program.options()
      .add_option("--contenders", peers.contenders, "these only: ID,ID, as the names of figures have them")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(ids()));
  program.options().add_option("--csv", csv,
                               "also write a line for each contender, case, size and round to this file");
  if (const auto code = program.parse(argc, argv)) return *code;
  if (quick) peers.scale = quick_scale();
  peers.scale.rounds = rounds.value_or(peers.scale.rounds);
  if (!csv.empty()) peers.csv.open(csv);
  if (peers.csv.fail()) {
    fmt::print(stderr, "cannot write {}\n", csv);
    return 1;
  }
  return sft::test::run_isolated([&] {
    const int code = program.run();
    peers.finish();
    return code;
  });
}
