// Measures bytes on the link. Interfaces cut trains into frames here, so that each frame is counted with its
// headers.
#include <cmath>
#include <string>

#include "bench/udp/flow.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

// Of a bulk sample: its number, its stamp, and the length of its data.
constexpr std::uint32_t fixed_body_bytes = 20;
constexpr double frame_headers = 14 + 20 + 8;  // of Ethernet, IPv4 and UDP
constexpr double frame_payload_max = 1472;     // at an MTU of 1500

/// The bytes of frames without any header of SFT, all of them full except the last one.
double packed_perfectly(double body_bytes) {
  return body_bytes + std::ceil(body_bytes / frame_payload_max) * frame_headers;
}

struct Size {
  const char* name;
  std::uint32_t body_bytes;
  std::uint64_t samples;  ///< per second
};

Figure overhead(const Size& size, bool reliable, const TwoHosts& hosts) {
  const Flow flow{.topic = {.bulk_bytes = size.body_bytes - fixed_body_bytes, .reliable = reliable},
                  .samples = size.samples,
                  .period_us = 1'000'000 / static_cast<std::int64_t>(size.samples)};
  return {std::string("wire_overhead_") + size.name + (reliable ? "_reliable" : ""),
          pass(flow, hosts).link_bytes / static_cast<double>(size.samples),
          "B",
          packed_perfectly(size.body_bytes),
          "CDR and headers, packed perfectly",
          1.03};
}

double data_bytes(const Flow& flow) {
  return static_cast<double>(flow.samples) * (flow.topic.bulk_bytes + fixed_body_bytes);
}

/// The control traffic in percent of the samples.
Figure percentage(const char* name, const Flow& flow, const TwoHosts& hosts) {
  return {name, 100 * pass(flow, hosts).control_bytes / data_bytes(flow), "%", {}, "of the samples' bytes",
          1};
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

std::vector<Figure> ack_overhead(const Scale&) {
  const TwoHosts hosts(Trains::cut);
  const Flow large{.topic = {.bulk_bytes = 100'000}, .samples = 400, .period_us = 5000};
  const Flow small{.topic = {.bulk_bytes = 1000}, .samples = 4000, .period_us = 500};
  const Flow slow{.topic = {.bulk_bytes = 64'000}, .samples = 50, .period_us = 200'000};
  const Passage slowly = pass(slow, hosts);
  return {percentage("ack_overhead", large, hosts),
          percentage("ack_overhead_1KB", small, hosts),
          {"ack_datagrams_per_s", slowly.control_datagrams / slowly.seconds, "/s", {}, "at 0.3 MB/s", 1}};
}

}  // namespace sft::bench
