// Measures half the time of a round trip, as `sft perf` reports it and as a program measures it that does
// nothing else.
#include <signal.h>
#include <sys/prctl.h>

#include <sft/sft.h>
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "bench/common/node_options.h"
#include "bench/common/pair.h"
#include "bench/common/process.h"
#include "bench/common/statistics.h"
#include "bench/tools/programs.h"
#include "bench/tools/tools.h"
#include "tests/support/temporary_directory.h"

namespace sft::bench {

namespace {

constexpr double overhead_bound = 1.05;
constexpr std::int64_t rate_hz = 500;
constexpr std::size_t ping_bytes = 64;

/// Returns half the times of round trips that `sft perf` reports, in us; nothing if it failed.
std::vector<double> reported_by_perf(const std::string& transport, double seconds,
                                     const test::TemporaryDirectory& folder) {
  const std::string output = folder.path() / "ping.json";
  const pid_t pong = start_sft(1, {"perf", "pong"}, "/dev/null");
  const bool done = succeeds(
      start_sft(0,
                {"perf", "ping", "--size", std::to_string(ping_bytes), "--rate", std::to_string(rate_hz),
                 "--for", std::to_string(seconds), "--transport", transport, "--timeout", "20", "--json"},
                output));
  kill(pong, SIGINT);
  succeeds(pong);
  const nlohmann::json result = last_json(output);
  if (!done || result["lanes"].empty()) return {};
  return {result["lanes"][0]["latency_s"]["p50"].get<double>() * 1e6};
}

/// A publisher and a subscriber of encoded messages. As in `sft perf`, the type is known only at run time.
struct Ends {
  Ends(const char* name, TransportChoice transport, const char* sends, const char* hears,
       std::function<void(const DynamicSample&)> heard)
      : node(Node::open(node_options(name, transport)).value()),
        publisher(node.publisher(sends, type).value()),
        subscriber(node.subscriber(hears, type, "*", {.depth = 256}, std::move(heard)).value()) {}

  void send() { (void)publisher.publish_cdr(message); }

  const DynamicType type = from_msg("sft_bench/msg/Bytes", "uint8[] data\n").value();
  const std::vector<std::byte> message = encoded();
  Node node;
  DynamicPublisher publisher;
  DynamicSubscriber subscriber;

 private:
  static std::vector<std::byte> encoded() {
    std::vector<std::byte> cdr(8 + ping_bytes);
    cdr[1] = std::byte{1};
    cdr[4] = std::byte{ping_bytes};
    return cdr;
  }
};

/// Answers each sample until the exchange is over.
void answer(TransportChoice transport, Exchange& exchange) {
  std::atomic<Ends*> answering{nullptr};
  Ends ends("pong", transport, "answers", "samples", [&](const DynamicSample&) {
    if (Ends* const to = answering) to->send();
  });
  answering = &ends;
  exchange.ready =
      wait_until([&] { return ends.publisher.wait_for_subscribers(1, std::chrono::seconds(0)); });
  wait_until([&] { return exchange.sent != 0; }, 60);
}

/// Sends samples by a schedule, and notes when their answers arrive.
void ask(TransportChoice transport, std::uint64_t count, Exchange& exchange) {
  prctl(PR_SET_TIMERSLACK, 1);
  Ends ends("ping", transport, "samples", "answers", [&](const DynamicSample& sample) {
    const std::uint64_t number = sample.info().sequence;
    if (number >= 1 && number <= count) exchange.note_receipt(number);
  });
  exchange.failed = !wait_until(
      [&] { return exchange.ready && ends.publisher.wait_for_subscribers(1, std::chrono::seconds(0)); });
  const std::int64_t begin = now_ns();
  for (std::uint64_t i = 0; i < count && !exchange.failed; ++i) {
    sleep_until(begin + static_cast<std::int64_t>(i) * (1'000'000'000 / rate_hz));
    exchange.sent_at[i] = now_ns();
    ends.send();
  }
  wait_until([&] { return exchange.received == count; }, 1);
  exchange.sent = count;
}

Figure measured(const char* name, const char* path, TransportChoice transport, const Scale& scale) {
  const test::TemporaryDirectory folder;
  const auto count = static_cast<std::uint64_t>(scale.seconds * rate_hz);
  Rounds reported, own;
  for (int round = 0; round < scale.rounds; ++round) {
    reported.add(reported_by_perf(path, scale.seconds, folder));
    std::vector<double> times = run_pair({.sender = [&](Exchange& e) { ask(transport, count, e); },
                                          .receiver = [&](Exchange& e) { answer(transport, e); }},
                                         count);
    for (double& time : times) time /= 2;
    own.add(std::move(times));
  }
  return {name, reported.p50(), "us", own.p50(), "a program of its own", overhead_bound};
}

}  // namespace

std::vector<Figure> perf(const Scale& scale) {
  return {measured("perf_overhead", "shm", TransportChoice::shm, scale),
          measured("perf_overhead_udp", "udp", TransportChoice::udp, scale)};
}

}  // namespace sft::bench
