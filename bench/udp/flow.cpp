#include "bench/udp/flow.h"

#include <algorithm>

#include "bench/common/shared.h"
#include "bench/udp/control_counter.h"

namespace sft::bench {

namespace {

constexpr std::uint64_t samples_before = 10;
constexpr std::int64_t settling_us = 500'000;  // the traffic of joining is over after this time
constexpr std::int64_t quiet_us_max =
    2'000'000;  // long enough, since idle traffic is small against the samples

class Sender {
 public:
  Sender(Exchange& exchange, Writer& writer) : exchange_(exchange), writer_(writer) {}

  /// Sends samples. True if all samples have arrived so far.
  bool send(std::uint64_t samples, std::int64_t period_us) {
    const std::int64_t begin = now_ns();
    for (std::uint64_t i = 0; i < samples; ++i) {
      writer_.write(++sent_);
      const std::int64_t next = begin + static_cast<std::int64_t>(i + 1) * period_us * 1000;
      if (const std::int64_t left = next - now_ns(); left > 0) sleep_us(left / 1000);
    }
    return wait_until([&] { return exchange_.received.load() >= sent_; });
  }

 private:
  Exchange& exchange_;
  Writer& writer_;
  std::uint64_t sent_ = 0;
};

double link_bytes_per_s_when_quiet(std::int64_t us) {
  const std::int64_t before = link_bytes().sent;
  sleep_us(us);
  return static_cast<double>(link_bytes().sent - before) * 1e6 / static_cast<double>(us);
}

bool send(Exchange& exchange, const Flow& flow, Passage& passage) {
  const auto peer = sft_peer();
  const auto writer = peer->writer(flow.topic);
  if (!wait_until([&] { return exchange.ready.load() && writer->readers() == 1; })) return false;
  Sender sender(exchange, *writer);
  if (!sender.send(samples_before, flow.period_us)) return false;
  sleep_us(settling_us);
  const ControlCounter control;
  const std::int64_t link_before = link_bytes().sent;
  const std::int64_t begin = now_ns();
  if (!sender.send(flow.samples, flow.period_us)) return false;
  const double seconds = static_cast<double>(now_ns() - begin) / 1e9;
  const auto link = static_cast<double>(link_bytes().sent - link_before);
  const ControlTraffic traffic = control.read();
  const auto quiet_us = std::min(quiet_us_max, static_cast<std::int64_t>(seconds * 1e6));
  passage = {.link_bytes = link - link_bytes_per_s_when_quiet(quiet_us) * seconds,
             .control_bytes = static_cast<double>(traffic.bytes),
             .control_datagrams = static_cast<double>(traffic.datagrams),
             .seconds = seconds};
  return true;
}

void receive(Exchange& exchange, const Topic& topic) {
  const auto peer = sft_peer();
  const auto reader = peer->reader(topic, [&](std::uint64_t) { exchange.received.fetch_add(1); });
  while (reader->writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.sent.load() == 0 && !exchange.failed.load()) sleep_us(10'000);
}

}  // namespace

Passage pass(const Flow& flow, const TwoHosts& hosts) {
  const Shared<Passage> passage;
  run_pair(hosts.sides(
               [&](Exchange& exchange) {
                 exchange.failed = !send(exchange, flow, *passage);
                 exchange.sent = 1;
               },
               [&](Exchange& exchange) { receive(exchange, flow.topic); }),
           0);
  return *passage;
}

}  // namespace sft::bench
