#include "tools/perf/usage.h"

#include <fmt/format.h>
#include <net/if.h>
#include <sys/resource.h>
#include <sys/timex.h>

#include <algorithm>
#include <ctime>
#include <fstream>

#include "tools/hosts/interface_counters.h"

namespace sft::perf {

namespace {

std::int64_t read_clock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

std::string first_line(const std::string& file) {
  std::string line;
  std::ifstream in(file);
  std::getline(in, line);
  return line;
}

}  // namespace

std::int64_t now_ns() { return read_clock(CLOCK_MONOTONIC); }
std::int64_t time_ns() { return read_clock(CLOCK_REALTIME); }

Usage usage_now() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  Usage usage{.cpu_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime),
              .switches = static_cast<std::uint64_t>(used.ru_nvcsw + used.ru_nivcsw),
              .memory_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024};
  struct if_nameindex* const interfaces = if_nameindex();
  for (const auto* i = interfaces; i != nullptr && i->if_index != 0; ++i) {
    if (std::string(i->if_name) == "lo") continue;
    const auto bytes = hosts::interface_bytes(i->if_name).value_or(hosts::InterfaceBytes{});
    usage.bytes_in += bytes.received;
    usage.bytes_out += bytes.sent;
  }
  if (interfaces != nullptr) if_freenameindex(interfaces);
  return usage;
}

Usage operator-(const Usage& after, const Usage& before) {
  return {after.cpu_s - before.cpu_s, after.switches - before.switches,
          after.bytes_in - std::min(before.bytes_in, after.bytes_in),
          after.bytes_out - std::min(before.bytes_out, after.bytes_out), after.memory_bytes};
}

Usage operator+(const Usage& one, const Usage& other) {
  return {one.cpu_s + other.cpu_s, one.switches + other.switches, one.bytes_in + other.bytes_in,
          one.bytes_out + other.bytes_out, std::max(one.memory_bytes, other.memory_bytes)};
}

HostClock host_clock() {
  timex state{};
  // chrony, ntpd and phc2sys report the error of the clock to the kernel
  const int result = adjtimex(&state);
  return {.boot = first_line("/proc/sys/kernel/random/boot_id"),
          .is_kept = result >= 0 && result != TIME_ERROR && (state.status & STA_UNSYNC) == 0,
          .error_s = static_cast<double>(state.maxerror) * 1e-6};
}

Agreement agreement(const HostClock& here, const HostClock& there) {
  if (!here.boot.empty() && here.boot == there.boot) return {"one clock, of one host", 0};
  if (!here.is_kept || !there.is_kept)
    return {fmt::format("the clock of {} is not kept by NTP or PTP, as adjtimex() says",
                        here.is_kept    ? "the other host"
                        : there.is_kept ? "this host"
                                        : "both hosts"),
            std::nullopt};
  const double within = here.error_s + there.error_s;
  return {fmt::format("NTP or PTP keeps both clocks within {:.3g} ms, as adjtimex() says", within * 1e3),
          within};
}

std::string idle_settings() {
  const std::string cpu = "/sys/devices/system/cpu/cpu0/";
  const std::string governor = first_line(cpu + "cpufreq/scaling_governor");
  std::string states;
  for (int i = 0; i < 16; ++i) {
    const std::string name = first_line(cpu + "cpuidle/state" + std::to_string(i) + "/name");
    if (name.empty()) break;
    states += ' ' + name;
  }
  std::string settings = governor.empty() ? "" : "governor " + governor;
  if (!states.empty()) settings += (settings.empty() ? "" : ", ") + ("idle states" + states);
  return settings;
}

}  // namespace sft::perf
