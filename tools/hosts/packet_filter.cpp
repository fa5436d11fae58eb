#include "tools/hosts/packet_filter.h"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>

#include "tools/hosts/system_error.h"

namespace sft::hosts {

Result<core::FileDescriptor> open_packets(const std::string& interface, std::span<const sock_filter> filter,
                                          int buffer_bytes) {
  core::FileDescriptor packets(socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (buffer_bytes > 0) {
    setsockopt(packets.get(), SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  }
  const sock_fprog program{.len = static_cast<unsigned short>(filter.size()),
                           .filter = const_cast<sock_filter*>(filter.data())};
  // The socket is bound to its interface, and to all protocols, only after the filter is in place.
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  const bool open = packets &&
                    setsockopt(packets.get(), SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0 &&
                    (address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()))) != 0 &&
                    bind(packets.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  if (!open) return system_error("the traffic of " + interface + " cannot be counted");
  return packets;
}

}  // namespace sft::hosts
