// The socket by which datagrams of multicast groups enter a process, and how others leave for groups.
#pragma once

#include <cstddef>

#include "core/platform/file_descriptor.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

using core::FileDescriptor;

struct GroupSocket {
  FileDescriptor group_fd{};   ///< receives what groups get
  FileDescriptor either_fd{};  ///< readable if this socket or the unicast one is
};

/// Opens a second socket beside the one that receives, bound to the port of groups, which processes of a host
/// share; it receives nothing until a group is joined (group_joins.h). Both descriptors are invalid where
/// that port is not to be had.
GroupSocket open_group_socket(int unicast_fd, std::size_t receive_buffer_bytes) noexcept;

/// Datagrams that this socket sends to groups leave by the link where the host has that IPv4 address, and go
/// no further than the link. They do not come back to this host: readers that are reached by loopback are in
/// no group.
void send_to_groups_by(int fd, const SocketAddress& own) noexcept;

}  // namespace sft::udp
