// Samples over UDP, behind the seam of core/seam/transport.h. A transport has one socket that receives and
// one for each address that it sends to, and one receiving and one sending thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/platform/thread.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/multicast_links.h"
#include "udp_transport/receive/reassembly_memory.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

enum class Backend : std::uint8_t {
  automatic,  ///< io_uring if the kernel allows it, else plain sockets
  io_uring,
  sockets,
};

struct UdpOptions {
  std::uint16_t port = 0;          ///< port that the socket is bound to; 0: any free one
  core::IpAddress bind_address{};  ///< default: all addresses of the host, of both families
  /// Addresses to announce; empty: `bind_address`, or those of the host.
  std::vector<core::IpAddress> advertised_addresses{};
  /// Limits the addresses of the host to these interfaces, by name, address or network (interfaces.h);
  /// empty: all that are up.
  std::vector<std::string> interfaces{};
  Backend backend = Backend::automatic;

  std::size_t max_sample_bytes = std::size_t{64} << 20;  ///< limit of a body that is sent or received
  /// Wanted size, as the kernel counts; it may grant less.
  std::size_t receive_buffer_bytes = std::size_t{32} << 20;
  /// Size for each address; devices have short queues; 0: default.
  std::size_t send_buffer_bytes = std::size_t{128} << 10;

  /// Longest datagram, with our header; a path may take less.
  std::size_t max_datagram_bytes = datagram_bytes_max;
  std::uint64_t max_bytes_per_s = 0;  ///< limit of all that is sent; 0: none
  Multicast multicast = Multicast::automatic;
  std::size_t send_queue_depth = 4;  ///< newest samples that wait, per writer, mask and address
  ReassemblyLimits reassembly{};     ///< `sample_bytes` is set from max_sample_bytes

  core::ThreadSpec receive_thread = "sft-udp-recv";
  core::ThreadSpec send_thread = "sft-udp-send";
};

/// Wraps the transport's I/O, for tests: with loss, delay, repetition, another order.
using DecorateIo = std::function<DatagramIo(DatagramIo)>;

/// Received samples lie in memory of `pool`, which belongs to the node.
Result<std::unique_ptr<core::Network>> open_udp_transport(const UdpOptions& options,
                                                          std::shared_ptr<core::BufferPool> pool,
                                                          const DecorateIo& decorate = {});

}  // namespace sft::udp
