// The resources that a process and its host use, and the error of the clock of the host.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sft::perf {

std::int64_t now_ns();   ///< by a clock that is never set
std::int64_t time_ns();  ///< the time of the host, in UTC

struct Usage {
  double cpu_s = 0;  ///< of all threads of the process, in the kernel and outside
  std::uint64_t switches = 0;
  std::uint64_t bytes_in = 0, bytes_out = 0;  ///< of all interfaces of the host, without the loopback
  std::uint64_t memory_bytes = 0;             ///< the most that the process had; not a difference
};
Usage usage_now();
/// Counts of interfaces that have disappeared since `before` are 0, and not less.
Usage operator-(const Usage& after, const Usage& before);
Usage operator+(const Usage& one, const Usage& other);

struct HostClock {
  std::string boot;  ///< equal on one host, whose programs share a clock
  bool is_kept = false;
  double error_s = 0;  ///< the most by which the clock is wrong, if it is kept
};
HostClock host_clock();

/// The agreement of two hosts' clocks, in words, and the maximum difference. Without a number, the difference
/// is not known.
struct Agreement {
  std::string words;
  std::optional<double> within_s;
};
Agreement agreement(const HostClock& here, const HostClock& there);

/// Returns what saves power while this host is idle: "governor schedutil, idle states POLL C1 C6"; empty if
/// the system does not tell.
std::string idle_settings();

}  // namespace sft::perf
