#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/udp/one_way.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

const Paced paced{.topic = {.bulk_bytes = 6'300'000}, .messages = 25, .period_us = 100'000};
constexpr double bound = 1.5;

class Contest {
 public:
  explicit Contest(Contender contender) : contender_(contender) {}

  void run(const TwoHosts& hosts) {
    const std::vector<Delivery> deliveries = one_way_deliveries(contender_, paced, hosts);
    if (deliveries.empty()) return;
    first_ms_.push_back(deliveries.front().us() / 1000);
    std::vector<double> times;
    for (const Delivery& delivery : deliveries) times.push_back(delivery.us() / 1000);
    worst_ms_.push_back(quantile(times, 1));
    median_ms_.push_back(quantile(times, 0.5));
  }
  double worst_ms() const { return median_if_any(worst_ms_); }
  double median_ms() const { return median_if_any(median_ms_); }
  double first_ms() const { return median_if_any(first_ms_); }

 private:
  Contender contender_;
  std::vector<double> worst_ms_, median_ms_, first_ms_;
};

}  // namespace

std::vector<Figure> worst(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  Contest ours(sft_peer), loaned(sft_loan_peer), cyclone(cyclone_peer), tcp(raw_tcp_copying_peer);
  for (int round = 0; round < scale.rounds; ++round) {
    for (Contest* contest : {&ours, &loaned, &cyclone, &tcp}) contest->run(hosts);
  }
  return {{"worst_6.3MB", ours.worst_ms(), "ms", tcp.worst_ms(), "raw TCP after a memcpy", bound},
          {"worst_6.3MB_loan", loaned.worst_ms(), "ms", tcp.worst_ms(), "raw TCP after a memcpy", bound},
          {"worst_6.3MB_vs_cyclone", ours.worst_ms(), "ms", cyclone.worst_ms(), "Cyclone DDS"},
          {"paced_6.3MB", ours.median_ms(), "ms", tcp.median_ms(), "raw TCP after a memcpy"},
          {"first_6.3MB", ours.first_ms(), "ms", tcp.first_ms(), "raw TCP after a memcpy"}};
}

}  // namespace sft::bench
