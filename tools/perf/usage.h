// The resources that a process and its host use, and the error of the clock of the host.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sft::perf {

std::int64_t now_ns();   ///< the time of a clock that is never set
std::int64_t time_ns();  ///< the time of the host, in UTC

struct Usage {
  double cpu_s = 0;  ///< processor time of all threads of the process, in the kernel and in the program
  std::uint64_t switches = 0;
  std::uint64_t bytes_in = 0, bytes_out = 0;  ///< bytes of all interfaces of the host except the loopback
  std::uint64_t memory_bytes = 0;             ///< the maximum memory of the process so far; not a difference
};
Usage usage_now();
/// Returns the difference. The counts of interfaces that have disappeared since `before` become 0 instead
/// of negative.
Usage operator-(const Usage& after, const Usage& before);
Usage operator+(const Usage& one, const Usage& other);

struct HostClock {
  std::string boot;  ///< the boot id; it is equal for programs on one host, which share a clock
  bool is_kept = false;
  double error_s = 0;  ///< the maximum error of the clock, if a service keeps it synchronised
};
HostClock host_clock();

/// The agreement of two hosts' clocks in words, and their maximum difference. If there is no number, the
/// difference is not known.
struct Agreement {
  std::string words;
  std::optional<double> within_s;
};
Agreement agreement(const HostClock& here, const HostClock& there);

/// Returns the settings that save power while this host is idle: "governor schedutil, idle states POLL C1
/// C6"; empty if the system does not report them.
std::string idle_settings();

}  // namespace sft::perf
