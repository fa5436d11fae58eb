// Hosts that are real to every program on them: one network namespace each, joined by virtual cables to a
// switch.
//
// The namespaces have no names. They live as long as a process is in them or a descriptor refers to them.
// So the kernel removes them, with everything in them, in whatever way the program ends (kill -9 included).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::hosts {

inline constexpr const char* host_interface = "eth0";  ///< the interface of every host, besides "lo"

class NetworkNamespace {
 public:
  /// Creates an empty namespace. REQUIRES: the calling process has a single thread. That thread is moved
  /// into the namespace and back.
  static Result<NetworkNamespace> create();

  /// Moves the calling process into the namespace.
  Result<void> enter() const;
  /// Runs a command in the namespace, with `input` as its standard input. The error is the output of the
  /// command.
  Result<void> run(const std::vector<std::string>& command, std::string_view input = {}) const;
  int descriptor() const { return descriptor_.get(); }
  /// Returns a path of the namespace that other processes can open as long as this process lives.
  std::string path() const;

 private:
  explicit NetworkNamespace(core::FileDescriptor descriptor) : descriptor_(std::move(descriptor)) {}

  core::FileDescriptor descriptor_;
};

/// A switch and the hosts on it, each with an interface eth0 (MTU 1500) in 10.77.0.0/24.
class EmulatedNetwork {
 public:
  static Result<EmulatedNetwork> create(std::size_t hosts);

  const NetworkNamespace& host(std::size_t number) const { return hosts_[number]; }
  static std::string address(std::size_t number);

  /// Runs a command on the switch. The interface port(number) of the switch leads to the host with that
  /// number.
  Result<void> run_on_switch(const std::vector<std::string>& command) const { return switch_.run(command); }
  static std::string port(std::size_t number);

 private:
  EmulatedNetwork(NetworkNamespace network_switch, std::vector<NetworkNamespace> hosts)
      : switch_(std::move(network_switch)), hosts_(std::move(hosts)) {}
  Result<void> plug_in(std::size_t number) const;

  NetworkNamespace switch_;
  std::vector<NetworkNamespace> hosts_;
};

}  // namespace sft::hosts
