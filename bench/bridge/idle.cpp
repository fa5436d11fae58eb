#include "bench/bridge/bridge.h"
#include "bench/bridge/radio.h"
#include "bench/common/counters.h"
#include "bench/common/pair.h"
#include "core/platform/text_of.h"

namespace sft::bench {

namespace {

// The time in which bridges find each other, and their traffic becomes quiet
constexpr std::int64_t settling_us = 8'000'000;
constexpr double kilobytes_of_mb = 1000 / 1.024;

/// Returns the size of the process's memory that no file backs, in MB.
double anonymous_mb(pid_t process) {
  const std::string text = core::text_of("/proc/" + std::to_string(process) + "/status");
  const std::string key = "RssAnon:";
  const std::size_t at = text.find(key);
  return at == text.npos ? 0 : std::stod(text.substr(at + key.size())) / kilobytes_of_mb;
}

}  // namespace

std::vector<Figure> bridge_idle(const BridgeScale& scale) {
  const Radio radio = make_radio();
  const Bridges bridges(radio);
  sleep_us(settling_us);
  const ProcessCounter counter(bridges.of_robot());
  const Counts counts = sum_of(counter.read());
  const LinkBytes bytes = bridges.link_bytes();
  const std::int64_t begin = now_ns();
  sleep_us(static_cast<std::int64_t>(scale.seconds * 1e6));
  const Counts done = sum_of(counter.read()).since(counts);
  const LinkBytes now = bridges.link_bytes();
  const double seconds = static_cast<double>(now_ns() - begin) / 1e9;
  const auto each_second = [&](std::int64_t count) { return static_cast<double>(count) / seconds; };
  return {
      {"bridge_idle_sent", each_second(now.sent - bytes.sent), "B/s"},
      {"bridge_idle_received", each_second(now.received - bytes.received), "B/s"},
      {"bridge_idle_wake_ups", each_second(done.wake_ups), "/s"},
      {"bridge_idle_cpu", each_second(done.cpu_ns) / 1e7, "%"},
      {"bridge_idle_memory", anonymous_mb(bridges.of_robot()), "MB"},
  };
}

}  // namespace sft::bench
