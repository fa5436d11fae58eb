// Measures the cost of a waiting node: the processor time of a whole process with a subscriber, whose
// publisher is in another program.
#include <unistd.h>

#include "bench/common/contender.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/shm/shm.h"

namespace sft::bench {

namespace {

constexpr double allowed_percent = 0.5;
constexpr std::int64_t settling_us = 2'000'000;  // the time after which the traffic of joining is over

const Topic topic{.bulk_bytes = sent_cloud_bytes};

void keep_publisher(Exchange& exchange) {
  const auto peer = sft_cloud_loan_peer();
  const auto writer = peer->writer(topic);
  while (!writer->serves(1)) sleep_us(1000);
  exchange.sent = 1;
  while (exchange.received.load() == 0) sleep_us(10'000);
}

double percent_while_waiting(Exchange& exchange, double seconds) {
  const auto peer = sft_cloud_loan_peer();
  const auto reader = peer->reader(topic);
  while (exchange.sent.load() == 0) sleep_us(10'000);
  sleep_us(settling_us);
  const std::int64_t begin = now_ns();
  const std::int64_t end = begin + static_cast<std::int64_t>(seconds * 1e9);
  const double cpu_before = cpu_s(getpid());
  while (now_ns() < end) reader->wait();  // waits for at most a second
  const double percent = (cpu_s(getpid()) - cpu_before) / (static_cast<double>(now_ns() - begin) / 1e9) * 100;
  exchange.received = 1;
  return percent;
}

}  // namespace

std::vector<Figure> idle_cpu(const Scale& scale) {
  const Shared<double> percent;
  run_pair({.sender = keep_publisher,
            .receiver = [&](Exchange& e) { *percent = percent_while_waiting(e, scale.idle_s); }},
           0);
  return {{"idle_cpu", *percent, "%", allowed_percent, "what is allowed, of a core", 1.0}};
}

}  // namespace sft::bench
