#include "bench/udp/one_way.h"

namespace sft::bench {

namespace {

void send(Exchange& exchange, Contender contender, const Paced& paced) {
  const auto peer = contender();
  const auto writer = peer->writer(paced.topic);
  const auto arrived = [&](std::uint64_t number) {
    return exchange.received.load() >= number ||
           wait_until([&] { return exchange.received.load() >= number; });
  };
  exchange.failed = !wait_until([&] { return exchange.ready.load() && writer->readers() == 1; });
  const std::int64_t begin = now_ns();
  for (std::uint64_t i = 0; i < paced.messages && !exchange.failed.load(); ++i) {
    const std::int64_t due = begin + static_cast<std::int64_t>(i + 1) * paced.period_us * 1000;
    if (const std::int64_t left = due - now_ns(); left > 0) sleep_us(left / 1000);
    if (!arrived(i)) break;
    exchange.sent_at[i] = now_ns();
    writer->write(i + 1);
  }
  exchange.failed = exchange.failed.load() || !arrived(paced.messages);
}

void receive(Exchange& exchange, Contender contender, const Paced& paced) {
  const auto peer = contender();
  const auto reader = peer->reader(paced.topic, [&](std::uint64_t number) { exchange.note_receipt(number); });
  while (reader->writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.received.load() < paced.messages && !exchange.failed.load()) sleep_us(10'000);
}

Sides sides(Contender contender, const Paced& paced, const TwoHosts& hosts) {
  return hosts.sides([contender, &paced](Exchange& e) { send(e, contender, paced); },
                     [contender, &paced](Exchange& e) { receive(e, contender, paced); });
}

}  // namespace

std::vector<Delivery> one_way_deliveries(Contender contender, const Paced& paced, const TwoHosts& hosts) {
  return run_deliveries(sides(contender, paced, hosts), paced.messages);
}

std::vector<double> one_way_times(Contender contender, const Paced& paced, const TwoHosts& hosts) {
  return run_pair(sides(contender, paced, hosts), paced.messages);
}

}  // namespace sft::bench
