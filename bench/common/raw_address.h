// The addresses of the sockets of a topic. The contenders that use sockets have neither discovery nor
// names.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>

#include <cstdint>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

/// Returns the address at which a reader of a topic listens, or the address of all interfaces with its
/// port. Each topic has its own ports from `first_port` on, one for each reader, since all readers may be
/// on one host.
inline sockaddr_in reader_address(const Topic& topic, std::size_t reader, std::uint16_t first_port,
                                  bool all_interfaces = false) {
  constexpr std::size_t readers_max = 16;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(first_port + readers_max * topic.id + reader));
  address.sin_addr.s_addr = topic.on_one_host ? htonl(INADDR_LOOPBACK) : address_of(1 + reader);
  if (all_interfaces) address.sin_addr.s_addr = htonl(INADDR_ANY);
  return address;
}

}  // namespace sft::bench
