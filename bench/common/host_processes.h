// Runs processes on the hosts of a benchmark's own network.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "bench/common/hosts.h"

namespace sft::bench {

class HostProcesses {
 public:
  /// Makes host 0 and `hosts` further hosts, which exist as long as this object.
  explicit HostProcesses(std::size_t hosts);
  /// Uses host 0 and `hosts` further hosts of a network that several objects may use one after the other.
  HostProcesses(std::shared_ptr<const hosts::EmulatedNetwork> network, std::size_t hosts);
  /// Ends all processes.
  ~HostProcesses();
  HostProcesses(const HostProcesses&) = delete;
  HostProcesses& operator=(const HostProcesses&) = delete;

  /// Calls `run` in a new process on a host.
  pid_t start(std::size_t host, const std::function<int()>& run);
  /// Returns the host of the reader with this number: all hosts except host 0 are used in turns.
  std::size_t host_of_reader(std::size_t number) const { return 1 + number % (hosts_ - 1); }

  std::size_t hosts() const { return hosts_; }
  std::size_t size() const { return members_.size(); }
  /// Waits for the end of the process that was started first. Returns true if its exit code was 0.
  bool first_succeeds();

  // The following functions return sums over all processes, or over all interfaces.
  double cpu_s() const;
  double resident_bytes() const;
  /// Returns the size in bytes of the memory that no file backs, which is the memory that the processes
  /// have written.
  double anonymous_bytes() const;
  /// Returns the bytes that the interfaces of all hosts have received and sent. REQUIRES: there is a
  /// process on each host.
  LinkBytes link_bytes() const;

  /// Returns the bytes that one host's interface has received and sent. REQUIRES: there is a process on
  /// that host.
  LinkBytes link_bytes(std::size_t host) const;

 private:
  struct Member {
    pid_t process;
    std::size_t host;
  };

  double sum_of_bytes(const char* file, const char* key) const;

  const std::size_t hosts_;
  const std::shared_ptr<const hosts::EmulatedNetwork> network_;
  std::vector<Member> members_;
};

}  // namespace sft::bench
