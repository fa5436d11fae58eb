// 64 bytes from a program to one on another host and back: half of what that takes. Both do the same with
// what comes: a callback answers, or a thread waits for it, takes it and answers.
#include "bench/common/raw_sockets.h"
#include "bench/common/statistics.h"
#include "bench/udp/contender.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::size_t sample_bytes = 64;

enum class Way { callback, wait, spin };

Topic topic(const char* name, Way way) {
  return {.name = name, .reliable = false, .spinning = way == Way::spin};
}

/// Of the side that begins; the same number comes back.
class Rally {
 public:
  Rally(Exchange& exchange, std::uint64_t messages) : exchange_(exchange), messages_(messages) {}

  bool over() const { return exchange_.received.load() >= messages_ || exchange_.failed.load(); }
  std::uint64_t rounds() const { return exchange_.received.load(); }
  void serve(Writer& writer) {
    sent_at_ns_ = now_ns();
    writer.write(rounds() + 1);
  }
  /// Ignores what was given up before.
  void return_of(std::uint64_t number, Writer& writer) {
    const std::int64_t now = now_ns();
    if (number != rounds() + 1 || over()) return;
    exchange_.received_at[number - 1] = (now - sent_at_ns_) / 2;  // and sent_at 0
    exchange_.received = number;
    if (number < messages_) serve(writer);
  }

 private:
  Exchange& exchange_;
  const std::uint64_t messages_;
  std::int64_t sent_at_ns_ = 0;
};

/// Serves again after a second in which nothing came: a datagram was lost.
void wait_for_callbacks(Exchange& exchange, Rally& rally, Writer& writer) {
  for (std::uint64_t before = 0; !rally.over(); before = rally.rounds()) {
    for (int i = 0; i < 100 && !rally.over(); ++i) sleep_us(10'000);
    if (rally.over() || rally.rounds() != before) continue;
    exchange.failed = rally.rounds() == 0;
    rally.serve(writer);
  }
}

void ping(Exchange& exchange, Contender contender, Way way, std::uint64_t messages) {
  Rally rally(exchange, messages);
  const auto peer = contender();
  const auto writer = peer->writer(topic("ping", way));
  Arrived arrived;
  if (way == Way::callback) arrived = [&](std::uint64_t number) { rally.return_of(number, *writer); };
  const auto reader = peer->reader(topic("pong", way), arrived);
  exchange.failed =
      !wait_until([&] { return exchange.ready.load() && writer->readers() == 1 && reader->writers() == 1; });
  rally.serve(*writer);
  if (way == Way::callback) return wait_for_callbacks(exchange, rally, *writer);
  while (!rally.over()) {
    reader->wait();
    if (const std::uint64_t number = reader->take()) {
      rally.return_of(number, *writer);
    } else {
      rally.serve(*writer);
    }
  }
}

void pong(Exchange& exchange, Contender contender, Way way, std::uint64_t messages) {
  const auto peer = contender();
  const auto writer = peer->writer(topic("pong", way));
  Arrived arrived;
  if (way == Way::callback) arrived = [&](std::uint64_t number) { writer->write(number); };
  const auto reader = peer->reader(topic("ping", way), arrived);
  exchange.failed = !wait_until([&] { return writer->readers() == 1 && reader->writers() == 1; });
  exchange.ready = true;
  const Rally rally(exchange, messages);
  while (!rally.over()) {
    if (way == Way::callback) {
      sleep_us(10'000);
      continue;
    }
    reader->wait();
    if (const std::uint64_t number = reader->take()) writer->write(number);
  }
}

std::vector<double> times(Contender contender, Way way, const Scale& scale, const TwoHosts& hosts) {
  return run_pair(hosts.sides([&](Exchange& e) { ping(e, contender, way, scale.messages); },
                              [&](Exchange& e) { pong(e, contender, way, scale.messages); }),
                  scale.messages);
}

/// Our side and the others by one way to wait.
struct Contest {
  Way way;
  Rounds ours{}, cyclone{}, fast_dds{};

  void run(const Scale& scale, const TwoHosts& hosts) {
    ours.add(times(sft_peer, way, scale, hosts));
    cyclone.add(times(cyclone_peer, way, scale, hosts));
    fast_dds.add(times(fast_dds_peer, way, scale, hosts));
  }
  void figures(const std::string& name, const Rounds& raw, std::vector<Figure>& to) const {
    to.push_back({name, ours.p50(), "us", raw.p50(), "blocking sockets", 1.3});
    to.push_back({name + "_p99", ours.p99(), "us", raw.p99(), "blocking sockets"});
    to.push_back({name + "_vs_cyclone", ours.p50(), "us", cyclone.p50(), "Cyclone DDS", 1});
    to.push_back({name + "_vs_fast_dds", ours.p50(), "us", fast_dds.p50(), "Fast DDS", 1});
  }
};

}  // namespace

std::vector<Figure> small(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  Contest callback{Way::callback}, wait{Way::wait};
  Rounds spin, raw, raw_spin;
  for (int round = 0; round < scale.rounds; ++round) {
    raw.add(raw_socket_ping_pong(scale.messages, sample_bytes, Reading::sleeping, hosts));
    callback.run(scale, hosts);
    wait.run(scale, hosts);
    raw_spin.add(raw_socket_ping_pong(scale.messages, sample_bytes, Reading::spinning, hosts));
    spin.add(times(sft_peer, Way::spin, scale, hosts));
  }
  std::vector<Figure> figures;
  callback.figures("small_callback", raw, figures);
  wait.figures("small_wait", raw, figures);
  figures.push_back({"small_spin", spin.p50(), "us", raw_spin.p50(), "sockets, spinning", 2});
  figures.push_back({"small_spin_p99", spin.p99(), "us", raw_spin.p99(), "sockets, spinning"});
  return figures;
}

}  // namespace sft::bench
