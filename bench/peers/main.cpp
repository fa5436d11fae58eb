// Compares SFT with other middleware, sockets and memcpy: latency, throughput and processor time over sizes
// and readers, within one host and between hosts. Hosts are network namespaces with an MTU of 1500.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <thread>
#include <utility>

#include "bench/common/program.h"
#include "bench/peers/figures.h"
#include "bench/peers/tables.h"
#include "bench/peers/trial.h"
#include "tests/support/isolated_host.h"

namespace {

using namespace sft::bench;
using namespace sft::bench::peers;

constexpr const char* how =
    "This machine has {} cores. The writer's process is pinned to core 0 with all its threads, and the "
    "readers\n"
    "to core 1, which several readers share. Each message starts in the program's own memory; of a loan "
    "only\n"
    "the number is written. Latency is the time from publish() until the program of the last reader has the\n"
    "message: with \"two fields\" two numbers, otherwise all data, which SFT and iceoryx let it read in "
    "place.\n"
    "Within one host SFT shares all fields, whatever a reader asks for; between hosts it sends two only.\n"
    "Delivery is reliable: writers wait for readers that are late, but Cyclone DDS over iceoryx does not.\n"
    "\"lost\" tells what a reader did not get all the same.\n"
    "Latency: a message each {} us, or when the one before has arrived. Sleeping: everybody sleeps in "
    "between;\n"
    "SFT looks for 20 us before it sleeps, and with \"spin 0\" never. Spinning: writer and readers keep "
    "their\n"
    "cores busy; the DDS peers cannot, so that their readers sleep.\n"
    "Throughput: messages as fast as possible, which each reader got.\n"
    "CPU time is that of a message: of all processes, with spinning and discovery, divided by the messages.\n"
    "Figures are medians of the rounds ({}), and in parentheses the least and the most. Contenders take "
    "turns.\n"
    "A p99.9 with \"w\" is the worst of fewer than 1000 messages. memcpy alone, the floor, has no reader: "
    "its\n"
    "CPU time is what the benchmark itself takes to sleep and to wake up.\n";

/// Prints and flushes. Otherwise each process that is forked later would have a copy of the unwritten text.
void say(const std::string& text) {
  fmt::print("{}", text);
  std::fflush(stdout);
}

std::string title_of(const Case& of) {
  return std::string(of.where == Where::one_host ? "Within one host" : "Between hosts") +
         (of.waiting == Waiting::sleeping ? ", sleeping" : ", spinning");
}

/// Returns the ids of all entrants. All of them run in this case.
std::vector<std::string> ids() {
  std::vector<std::string> ids;
  for (const Entrant& entrant : entrants({Where::one_host, Waiting::sleeping})) ids.push_back(id_of(entrant));
  return ids;
}

class Peers {
 public:
  /// Measures all sizes with one reader.
  std::vector<Figure> sizes(const std::string& group, Where where, Waiting waiting) {
    const Case of{where, waiting};
    const Records records = measure(group, {of}, scale.sizes, scale.pace);
    return report(group, title_of(of) + ", one reader", records, columns_of_sizes(of, scale.sizes));
  }
  /// Measures some sizes with several readers that sleep.
  std::vector<Figure> readers(const std::string& group, Where where) {
    std::vector<Case> cases;
    for (const std::size_t readers : scale.readers) cases.push_back({where, Waiting::sleeping, readers});
    const Records records = measure(group, cases, scale.sizes_of_readers, scale.pace_of_readers);
    std::vector<Figure> figures;
    for (const std::uint32_t bytes : scale.sizes_of_readers) {
      const char* hosts = where == Where::one_host ? "" : " on a host each";
      const std::string title = fmt::format("{}, several readers{}, which share one core, {}",
                                            title_of(cases.front()), hosts, size_text(bytes));
      for (Figure& figure :
           report(group, title, records, columns_of_readers(cases.front(), scale.readers, bytes)))
        figures.push_back(std::move(figure));
    }
    return figures;
  }

  void finish() { write_csv(csv, records_); }

  Scale scale;
  std::vector<std::string> contenders;  ///< the ids of the entrants that run; empty: all run
  std::ofstream csv;

 private:
  bool runs(const Entrant& entrant) const {
    return contenders.empty() || std::ranges::find(contenders, id_of(entrant)) != contenders.end();
  }
  const Stage& stage(std::int64_t period_us) {
    if (stage_ == nullptr) {
      say(fmt::format(fmt::runtime(how), std::thread::hardware_concurrency(), period_us, scale.rounds));
      stage_ = std::make_unique<Stage>();
    }
    return *stage_;
  }
  /// Measures the entrants of the last case, which has the most readers, in all cases.
  Records measure(const std::string& group, const std::vector<Case>& cases,
                  const std::vector<std::uint32_t>& sizes, const Pace& pace) {
    Records measured;
    for (int round = 0; round < scale.rounds; ++round) {
      fmt::print(stderr, "  round {} of {}\n", round + 1, scale.rounds);
      for (const Case& of : cases) {
        for (const Entrant& entrant : turns(entrants(cases.back()), static_cast<std::size_t>(round))) {
          if (!runs(entrant)) continue;
          for (Record& record : run({of, entrant, sizes, pace}, stage(pace.period_us))) {
            record.group = group;
            record.round = static_cast<std::size_t>(round);
            measured.push_back(record);
          }
        }
      }
    }
    records_.insert(records_.end(), measured.begin(), measured.end());
    return measured;
  }
  static std::vector<Figure> report(const std::string& group, const std::string& title,
                                    const Records& records, const std::vector<Column>& columns) {
    say(tables(records, title, columns));
    return figures(group, records, columns);
  }

  std::unique_ptr<Stage> stage_;
  Records records_;
};

}  // namespace

int main(int argc, char** argv) {
  Peers peers;
  const auto sizes = [&](const char* name, Where where, Waiting waiting) {
    return Group{name, [&peers, name, where, waiting] { return peers.sizes(name, where, waiting); }};
  };
  const auto readers = [&](const char* name, Where where) {
    return Group{name, [&peers, name, where] { return peers.readers(name, where); }};
  };
  Program program(
      "SFT beside other middleware, sockets and memcpy",
      {sizes("intra_sleeping", Where::one_host, Waiting::sleeping),
       sizes("intra_spinning", Where::one_host, Waiting::spinning), readers("intra_readers", Where::one_host),
       sizes("inter_sleeping", Where::two_hosts, Waiting::sleeping),
       sizes("inter_spinning", Where::two_hosts, Waiting::spinning),
       readers("inter_readers", Where::two_hosts)});
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
