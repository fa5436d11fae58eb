// The socket that receives the datagrams of multicast groups, and a function that prepares other sockets for
// sending to groups.
#pragma once

#include <cstddef>

#include "core/platform/file_descriptor.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

using core::FileDescriptor;

struct GroupSocket {
  FileDescriptor group_fd{};   ///< receives datagrams to groups
  FileDescriptor either_fd{};  ///< readable if `group_fd` or the unicast socket is readable
};

/// Opens a second socket in addition to the unicast socket. It is bound to the port for groups, which the
/// processes of a host share. It receives nothing until a group is joined (group_joins.h). Both descriptors
/// are invalid if that port is not available.
GroupSocket open_group_socket(int unicast_fd, std::size_t receive_buffer_bytes) noexcept;

/// Makes the datagrams that the socket sends to groups leave by the link where the host has the IPv4 address
/// `own`. They are not routed beyond that link. They are not looped back to this host, because readers that
/// are reached by loopback are in no group.
void send_to_groups_by(int fd, const SocketAddress& own) noexcept;

}  // namespace sft::udp
