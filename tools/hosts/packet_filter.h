// A socket that receives those frames of an interface that a filter accepts. The filter runs in the kernel.
#pragma once

#include <linux/filter.h>

#include <cstdint>
#include <span>
#include <string>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::hosts {

// Offsets in an Ethernet frame, and in the IPv4 packet in it. Filters use them.
inline constexpr std::uint32_t ether_type = 12;
inline constexpr std::uint32_t ip_header = 14;
inline constexpr std::uint32_t ip_fragment = ip_header + 6;
inline constexpr std::uint32_t ip_protocol = ip_header + 9;
inline constexpr std::uint32_t udp_payload = ip_header + 8;  ///< the length of the IP header has to be added

/// Opens a socket for received and sent frames, which never blocks. `buffer_bytes` is the number of bytes
/// of accepted frames that can wait to be read; 0: the system's default.
Result<core::FileDescriptor> open_packets(const std::string& interface, std::span<const sock_filter> filter,
                                          int buffer_bytes = 0);

}  // namespace sft::hosts
