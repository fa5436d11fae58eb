// Measures half the round trip of 64 bytes between programs on two hosts. Both sides answer in the same way:
// in a callback, or in a thread that waits for the sample and takes it. The next sample is sent at once,
// while threads that spin before they sleep are awake, or later, when all threads sleep.
#include <atomic>
#include <utility>

#include "bench/common/contender.h"
#include "bench/common/raw_sockets.h"
#include "bench/common/statistics.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::size_t sample_bytes = 64;

constexpr std::int64_t asleep_after_us = 300;

enum class Way { callback, wait, spin };

struct Game {
  Way way{};
  std::int64_t pause_us = 0;  ///< the pause before each sample except the first
  Topic topic(const char* name) const {
    return {.name = name, .reliable = false, .spinning = way == Way::spin};
  }
};

/// The side that sends first. The other side returns the number of each sample.
class Rally {
 public:
  Rally(Exchange& exchange, std::uint64_t messages, bool answers_at_once)
      : exchange_(exchange), messages_(messages), answers_at_once_(answers_at_once) {}

  bool over() const { return exchange_.received.load() >= messages_ || exchange_.failed.load(); }
  std::uint64_t rounds() const { return exchange_.received.load(); }
  void serve(Writer& writer) {
    sent_at_ns_ = now_ns();
    writer.write(rounds() + 1);
  }
  /// Handles a number that the other side has returned. Ignores the number of a sample for which the sender
  /// no longer waits.
  void return_of(std::uint64_t number, Writer& writer) {
    const std::int64_t now = now_ns();
    if (number != rounds() + 1 || over()) return;
    // A latency instead of a time, since sent_at stays 0.
    exchange_.received_at[number - 1] = (now - sent_at_ns_) / 2;
    exchange_.received = number;
    if (number < messages_ && answers_at_once_) serve(writer);
  }

 private:
  Exchange& exchange_;
  const std::uint64_t messages_;
  const bool answers_at_once_;
  std::atomic<std::int64_t> sent_at_ns_{0};
};

/// Runs between callbacks. Sends the next sample when it is due. After a second without an answer, sends
/// again, since a datagram was lost.
void wait_for_callbacks(Exchange& exchange, Rally& rally, Writer& writer, std::int64_t pause_us) {
  std::uint64_t before = rally.rounds();
  for (std::int64_t served_at_ns = now_ns(); !rally.over();) {
    sleep_us(pause_us > 0 ? pause_us : 10'000);
    const bool came = rally.rounds() != std::exchange(before, rally.rounds());
    const bool lost = !came && now_ns() - served_at_ns > 1'000'000'000;
    if (lost) exchange.failed = rally.rounds() == 0;
    if (came) served_at_ns = now_ns();
    if (rally.over() || (!lost && !(came && pause_us > 0))) continue;
    served_at_ns = now_ns();
    rally.serve(writer);
  }
}

void take_each(Rally& rally, Reader& reader, Writer& writer, std::int64_t pause_us) {
  for (std::int64_t served_at_ns = now_ns(); !rally.over();) {
    reader.wait();
    const std::uint64_t number = reader.take();
    const bool lost = number == 0 && now_ns() - served_at_ns > 1'000'000'000;
    if (number != 0) rally.return_of(number, writer);
    if (number != 0 && pause_us > 0) sleep_us(pause_us);
    if (lost || (number != 0 && pause_us > 0)) rally.serve(writer);
    if (lost || number != 0) served_at_ns = now_ns();
  }
}

void ping(Exchange& exchange, Contender contender, const Game& game, std::uint64_t messages) {
  Rally rally(exchange, messages, game.pause_us == 0);
  const auto peer = contender();
  const auto writer = peer->writer(game.topic("ping"));
  Arrived arrived;
  if (game.way == Way::callback) arrived = [&](std::uint64_t number) { rally.return_of(number, *writer); };
  const auto reader = peer->reader(game.topic("pong"), arrived);
  exchange.failed =
      !wait_until([&] { return exchange.ready.load() && writer->readers() == 1 && reader->writers() == 1; });
  rally.serve(*writer);
  if (game.way == Way::callback) return wait_for_callbacks(exchange, rally, *writer, game.pause_us);
  take_each(rally, *reader, *writer, game.pause_us);
}

void pong(Exchange& exchange, Contender contender, const Game& game, std::uint64_t messages) {
  const auto peer = contender();
  const auto writer = peer->writer(game.topic("pong"));
  Arrived arrived;
  if (game.way == Way::callback) arrived = [&](std::uint64_t number) { writer->write(number); };
  const auto reader = peer->reader(game.topic("ping"), arrived);
  exchange.failed = !wait_until([&] { return writer->readers() == 1 && reader->writers() == 1; });
  exchange.ready = true;
  const auto over = [&] { return exchange.received.load() >= messages || exchange.failed.load(); };
  while (!over()) {
    if (game.way == Way::callback) {
      sleep_us(10'000);
      continue;
    }
    reader->wait();
    if (const std::uint64_t number = reader->take()) writer->write(number);
  }
}

std::vector<double> times(Contender contender, const Game& game, const Scale& scale, const TwoHosts& hosts) {
  return run_pair(hosts.sides([&](Exchange& e) { ping(e, contender, game, scale.messages); },
                              [&](Exchange& e) { pong(e, contender, game, scale.messages); }),
                  scale.messages);
}

/// SFT and the other contenders under the same conditions.
struct Contest {
  Game game;
  const char* raw_name = "blocking sockets";
  double bound = 1.3;
  Rounds ours{}, raw{}, cyclone{}, fast_dds{};

  void run(const Scale& scale, const TwoHosts& hosts) {
    const Reading reading = game.way == Way::spin ? Reading::spinning : Reading::sleeping;
    ours.add(times(sft_peer, game, scale, hosts));
    raw.add(raw_socket_ping_pong(scale.messages, sample_bytes, reading, hosts, game.pause_us));
    cyclone.add(times(cyclone_peer, game, scale, hosts));
    fast_dds.add(times(fast_dds_peer, game, scale, hosts));
  }
  void figures(const std::string& name, std::vector<Figure>& to) const {
    to.push_back({name, ours.p50(), "us", raw.p50(), raw_name, bound});
    to.push_back({name + "_p99", ours.p99(), "us", raw.p99(), raw_name});
    to.push_back({name + "_vs_cyclone", ours.p50(), "us", cyclone.p50(), "Cyclone DDS", 1});
    to.push_back({name + "_vs_fast_dds", ours.p50(), "us", fast_dds.p50(), "Fast DDS", 1});
  }
};

}  // namespace

std::vector<Figure> small(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  Contest callback{{Way::callback}}, wait{{Way::wait}}, spin{{Way::spin}, "sockets, spinning", 2};
  Contest callback_asleep{{Way::callback, asleep_after_us}}, wait_asleep{{Way::wait, asleep_after_us}};
  for (int round = 0; round < scale.rounds; ++round) {
    for (Contest* contest : {&callback, &wait, &spin, &callback_asleep, &wait_asleep})
      contest->run(scale, hosts);
  }
  std::vector<Figure> figures;
  callback.figures("small_callback", figures);
  wait.figures("small_wait", figures);
  spin.figures("small_spin", figures);
  callback_asleep.figures("small_callback_asleep", figures);
  wait_asleep.figures("small_wait_asleep", figures);
  return figures;
}

}  // namespace sft::bench
