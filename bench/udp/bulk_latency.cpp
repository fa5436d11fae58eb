#include <algorithm>

#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/udp/one_way.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::int64_t period_us = 50'000;
constexpr std::uint64_t messages_min = 20;

struct Size {
  const char* name;
  std::uint32_t bytes;
  Rounds ours{}, loaned{}, cyclone{}, fast_dds{}, tcp{}, copying_tcp{};

  void run(const Scale& scale, const TwoHosts& hosts) {
    const Topic topic{.bulk_bytes = bytes};
    const std::uint64_t messages = std::max(scale.messages / 50, messages_min);
    const auto times = [&](Contender contender) {
      return one_way_times(contender, {.topic = topic, .messages = messages, .period_us = period_us}, hosts);
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
    to.push_back({figure + "_loan_vs_publish", loaned.p50() / 1000, "ms", ours.p50() / 1000,
                  "publish(message)", 1.05});
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
