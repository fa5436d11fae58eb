#include <algorithm>
#include <cstdio>
#include <optional>

#include "bench/common/hosts.h"
#include "bench/common/statistics.h"
#include "bench/udp/ledger.h"
#include "bench/udp/one_way.h"
#include "bench/udp/udp.h"
#include "bench/udp/wire_tap.h"

namespace sft::bench {

namespace {

constexpr Paced paced{.topic = {.bulk_bytes = 6'300'000}, .messages = 25, .period_us = 100'000};
constexpr double bound = 1.5;

void print(const char* what, const Traffic& traffic, std::int64_t published_ns) {
  const auto us = [&](std::int64_t ns) { return static_cast<double>(ns - published_ns) / 1000; };
  if (traffic.packets == 0) return;
  std::printf("    %-22s %5zu packets, %9.3f MB, first at %8.0f us, last at %8.0f us", what, traffic.packets,
              static_cast<double>(traffic.bytes) / 1e6, us(traffic.first_ns), us(traffic.last_ns));
  std::printf("; longest pause %7.0f us, from %8.0f us on\n", static_cast<double>(traffic.pause_ns) / 1000,
              us(traffic.pause_at_ns));
}

/// Notes what passes both ends of the link.
class Trace {
 public:
  explicit Trace(const TwoHosts& hosts)
      : sender_([&] { hosts.enter(0); }), receiver_([&] { hosts.enter(1); }) {}

  void forget() {
    sender_.packets();
    receiver_.packets();
  }
  void print_worst(const char* name, const std::vector<Delivery>& deliveries) {
    const std::vector<Packet> at_sender = sender_.packets(), at_receiver = receiver_.packets();
    const auto worst = std::ranges::max_element(deliveries, {}, &Delivery::us);
    if (worst == deliveries.end()) return;
    std::printf("%s: the worst of %zu samples is number %td, with %.0f us from publish to callback\n", name,
                deliveries.size(), worst - deliveries.begin() + 1, worst->us());
    print_ledger(*worst, deliveries, at_sender, at_receiver);
    using Kind = Packet::Kind;
    const std::int64_t from = worst->sent_at;
    print("data leave", traffic(at_sender, *worst, true, Kind::data), from);
    print("data arrive", traffic(at_receiver, *worst, false, Kind::data), from);
    print("answers leave", traffic(at_receiver, *worst, true, Kind::answer), from);
    print("answers arrive", traffic(at_sender, *worst, false, Kind::answer), from);
    if (sender_.lost() || receiver_.lost()) std::printf("    Some packets were not noted.\n");
    std::fflush(stdout);  // otherwise each of the next processes has these lines, too
  }

 private:
  static void print_ledger(const Delivery& worst, const std::vector<Delivery>& deliveries,
                           const std::vector<Packet>& at_sender, const std::vector<Packet>& at_receiver) {
    std::vector<Ledger> ledgers;
    for (const Delivery& delivery : deliveries) {
      if (const auto ledger = ledger_of(delivery, at_sender, at_receiver)) ledgers.push_back(*ledger);
    }
    if (const auto ledger = ledger_of(worst, at_sender, at_receiver))
      std::printf("%s", table_of(*ledger, medians_of(ledgers)).c_str());
    if (ledgers.size() < deliveries.size())
      std::printf("    Of %zu samples no packets were noted.\n", deliveries.size() - ledgers.size());
  }

  WireTap sender_, receiver_;
};

class Contest {
 public:
  Contest(const char* name, Contender contender) : name_(name), contender_(contender) {}

  void run(const TwoHosts& hosts, std::optional<Trace>& trace) {
    if (trace) trace->forget();
    const std::vector<Delivery> deliveries = one_way_deliveries(contender_, paced, hosts);
    if (trace) trace->print_worst(name_, deliveries);
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
  const char* name_;
  Contender contender_;
  std::vector<double> worst_ms_, median_ms_, first_ms_;
};

}  // namespace

std::vector<Figure> worst(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  std::optional<Trace> trace;
  if (scale.trace) trace.emplace(hosts);
  Contest ours("SFT", sft_peer), loaned("SFT, loaned", sft_loan_peer), cyclone("Cyclone DDS", cyclone_peer),
      tcp("raw TCP", raw_tcp_copying_peer);
  for (int round = 0; round < scale.rounds; ++round) {
    for (Contest* contest : {&ours, &loaned, &cyclone, &tcp}) contest->run(hosts, trace);
  }
  return {{"worst_6.3MB", ours.worst_ms(), "ms", tcp.worst_ms(), "raw TCP after a memcpy", bound},
          {"worst_6.3MB_loan", loaned.worst_ms(), "ms", tcp.worst_ms(), "raw TCP after a memcpy", bound},
          {"worst_6.3MB_vs_cyclone", ours.worst_ms(), "ms", cyclone.worst_ms(), "Cyclone DDS"},
          {"paced_6.3MB", ours.median_ms(), "ms", tcp.median_ms(), "raw TCP after a memcpy"},
          {"first_6.3MB", ours.first_ms(), "ms", tcp.first_ms(), "raw TCP after a memcpy"}};
}

}  // namespace sft::bench
