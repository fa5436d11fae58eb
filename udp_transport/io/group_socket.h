// The socket by which datagrams of multicast groups enter a process, and functions that make other sockets
// send to groups.
#pragma once

#include <cstddef>

#include "core/platform/file_descriptor.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

using core::FileDescriptor;

struct GroupSocket {
  FileDescriptor group_fd{};   ///< receives datagrams to groups
  FileDescriptor either_fd{};  ///< readable if `group_fd` or the unicast socket is
};

/// Opens a second socket beside the unicast one. It is bound to the port for groups, which the processes of
/// a host share, and receives nothing until a group is joined (group_joins.h). Both descriptors are invalid
/// if that port is not available.
GroupSocket open_group_socket(int unicast_fd, std::size_t receive_buffer_bytes) noexcept;

/// Makes the datagrams that this socket sends to groups leave by the link where the host has that IPv4
/// address, and go no further than that link. The datagrams do not come back to this host, because readers
/// that are reached by loopback are in no group.
void send_to_groups_by(int fd, const SocketAddress& own) noexcept;

}  // namespace sft::udp
