// The kernel's counters of a network interface, in the network namespace of the calling process.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sft::hosts {

/// The number of bytes that an interface has received and sent since it was made, with link-layer headers.
struct InterfaceBytes {
  std::uint64_t received = 0;
  std::uint64_t sent = 0;
  friend bool operator==(const InterfaceBytes&, const InterfaceBytes&) = default;
};

/// Returns the counters; empty if there is no such interface.
std::optional<InterfaceBytes> interface_bytes(const std::string& interface);

/// Finds the counters of an interface in the text of /proc/net/dev.
std::optional<InterfaceBytes> parse_interface_bytes(const std::string& text, const std::string& interface);

}  // namespace sft::hosts
