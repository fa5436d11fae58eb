// Measures bytes on the link. The virtual interfaces of this benchmark cut trains of datagrams into frames,
// so that each frame is counted with its headers.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"
#include "bench/common/shared.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

/// Samples of SFT at a constant rate from one host to another.
struct Flow {
  Topic topic;
  std::uint64_t samples = 0;
  std::int64_t period_us = 0;
};

constexpr std::uint64_t samples_before = 10;
constexpr std::int64_t settling_us = 500'000;  // the time after which the traffic of joining is over
// The maximum time for which idle traffic is measured. Idle traffic is much less than the traffic of
// samples.
constexpr std::int64_t quiet_us_max = 2'000'000;

class Sender {
 public:
  Sender(Exchange& exchange, Writer& writer) : exchange_(exchange), writer_(writer) {}

  /// Sends samples. Returns true if all samples have arrived so far.
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

/// Returns the number of bytes that are sent for the samples, without the bytes that are sent in the same
/// time without samples. Returns nothing if a sample did not arrive.
std::optional<double> send(Exchange& exchange, const Flow& flow) {
  const auto peer = sft_peer();
  const auto writer = peer->writer(flow.topic);
  if (!wait_until([&] { return exchange.ready.load() && writer->readers() == 1; })) return std::nullopt;
  Sender sender(exchange, *writer);
  if (!sender.send(samples_before, flow.period_us)) return std::nullopt;
  sleep_us(settling_us);
  const std::int64_t before = link_bytes().sent;
  const std::int64_t begin = now_ns();
  if (!sender.send(flow.samples, flow.period_us)) return std::nullopt;
  const double seconds = static_cast<double>(now_ns() - begin) / 1e9;
  const auto bytes = static_cast<double>(link_bytes().sent - before);
  const auto quiet_us = std::min(quiet_us_max, static_cast<std::int64_t>(seconds * 1e6));
  return bytes - link_bytes_per_s_when_quiet(quiet_us) * seconds;
}

void receive(Exchange& exchange, const Topic& topic) {
  const auto peer = sft_peer();
  const auto reader = peer->reader(topic, [&](std::uint64_t) { exchange.received.fetch_add(1); });
  while (reader->writers() == 0) sleep_us(1000);
  exchange.ready = true;
  while (exchange.sent.load() == 0 && !exchange.failed.load()) sleep_us(10'000);
}

/// Returns the bytes of send(); NaN if a sample did not arrive.
double bytes_of(const Flow& flow, const TwoHosts& hosts) {
  const Shared<double> bytes;
  run_pair(hosts.sides(
               [&](Exchange& exchange) {
                 *bytes = send(exchange, flow).value_or(std::numeric_limits<double>::quiet_NaN());
                 exchange.failed = std::isnan(*bytes);
                 exchange.sent = 1;
               },
               [&](Exchange& exchange) { receive(exchange, flow.topic); }),
           0);
  return *bytes;
}

// The bytes of a bulk sample's number, stamp, and length of the data.
constexpr std::uint32_t fixed_body_bytes = 20;
constexpr double frame_headers = 14 + 20 + 8;  // headers of Ethernet, IPv4 and UDP
constexpr double frame_payload_max = 1472;     // the payload at an MTU of 1500

/// Returns the number of bytes of frames that carry the body without headers of SFT. All frames are full
/// except the last one.
double packed_perfectly(double body_bytes) {
  return body_bytes + std::ceil(body_bytes / frame_payload_max) * frame_headers;
}

struct Size {
  const char* name;
  std::uint32_t body_bytes;
  std::uint64_t samples;  ///< the number of samples per second
};

Figure overhead(const Size& size, bool reliable, const TwoHosts& hosts) {
  const Flow flow{.topic = {.bulk_bytes = size.body_bytes - fixed_body_bytes, .reliable = reliable},
                  .samples = size.samples,
                  .period_us = 1'000'000 / static_cast<std::int64_t>(size.samples)};
  return {std::string("wire_overhead_") + size.name + (reliable ? "_reliable" : ""),
          bytes_of(flow, hosts) / static_cast<double>(size.samples),
          "B",
          packed_perfectly(size.body_bytes),
          "CDR and headers, packed perfectly",
          1.03};
}

}  // namespace

std::vector<Figure> wire_overhead(const Scale&) {
  const TwoHosts hosts(Trains::cut);
  std::vector<Figure> figures;
  for (const Size& size :
       {Size{"1.1KB", 1100, 2000}, {"2.2KB", 2200, 1000}, {"64KB", 65'536, 100}, {"4MiB", 4 << 20, 10}}) {
    for (const bool reliable : {false, true}) figures.push_back(overhead(size, reliable, hosts));
  }
  return figures;
}

}  // namespace sft::bench
