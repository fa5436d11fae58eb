#include <algorithm>

#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/udp/contender.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::int64_t period_us = 50'000;
constexpr std::uint64_t messages_min = 20;

void send(Exchange& exchange, Contender contender, const Topic& topic, std::uint64_t messages) {
  const auto peer = contender();
  const auto writer = peer->writer(topic);
  exchange.failed = !wait_until([&] { return exchange.ready.load() && writer->readers() == 1; });
  for (std::uint64_t i = 0; i < messages && !exchange.failed.load(); ++i) {
    sleep_us(period_us);
    exchange.sent_at[i] = now_ns();
    writer->write(i + 1);
    exchange.failed = !wait_until([&] { return exchange.received.load() > i; });
  }
}

void receive(Exchange& exchange, Contender contender, const Topic& topic, std::uint64_t messages) {
  const auto peer = contender();
  const auto reader = peer->reader(topic, [&](std::uint64_t number) { exchange.note_receipt(number); });
  while (reader->writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(10'000);
}

struct Size {
  const char* name;
  std::uint32_t bytes;
  Rounds ours{}, loaned{}, cyclone{}, fast_dds{}, tcp{}, copying_tcp{};

  void run(const Scale& scale, const TwoHosts& hosts) {
    const Topic topic{.bulk_bytes = bytes};
    const std::uint64_t messages = std::max(scale.messages / 50, messages_min);
    const auto times = [&](Contender contender) {
      return run_pair(hosts.sides([&](Exchange& e) { send(e, contender, topic, messages); },
                                  [&](Exchange& e) { receive(e, contender, topic, messages); }),
                      messages);
    };
    ours.add(times(sft_peer));
    loaned.add(times(sft_loan_peer));
    cyclone.add(times(cyclone_peer));
    fast_dds.add(times(fast_dds_peer));
    tcp.add(times(raw_tcp_peer));
    copying_tcp.add(times(raw_tcp_copying_peer));
  }
  void figures(std::vector<Figure>& to) const {
    const std::string figure = std::string("bulk_latency_") + name;
    figures(figure, ours, to);
    to.push_back({figure + "_vs_copying_tcp", ours.p50() / 1000, "ms", copying_tcp.p50() / 1000,
                  "raw TCP after a memcpy"});
    figures(figure + "_loan", loaned, to);
  }
  void figures(const std::string& figure, const Rounds& of, std::vector<Figure>& to) const {
    const double ms = of.p50() / 1000;
    to.push_back({figure, ms, "ms", cyclone.p50() / 1000, "Cyclone DDS", 1. / 3});
    to.push_back({figure + "_vs_fast_dds", ms, "ms", fast_dds.p50() / 1000, "Fast DDS", 1. / 3});
    to.push_back({figure + "_vs_tcp", ms, "ms", tcp.p50() / 1000, "raw TCP", 1});
  }
};

}  // namespace

std::vector<Figure> bulk_latency(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  Size medium{"1.66MB", 1'660'000}, large{"6.3MB", 6'300'000};
  for (int round = 0; round < scale.rounds; ++round) {
    medium.run(scale, hosts);
    large.run(scale, hosts);
  }
  std::vector<Figure> figures;
  medium.figures(figures);
  large.figures(figures);
  return figures;
}

}  // namespace sft::bench
