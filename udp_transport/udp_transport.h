// Samples over UDP, behind the seam of core/seam/transport.h. A transport has one socket that receives, one
// socket for each address that it sends to, one receiving thread and one sending thread.
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
  /// The requested size, as the kernel counts; the kernel may grant less.
  std::size_t receive_buffer_bytes = std::size_t{32} << 20;
  /// The size of the send buffer for each address; small because devices have short queues; 0: the default.
  std::size_t send_buffer_bytes = std::size_t{128} << 10;

  /// The longest datagram, with our header, in bytes. A path may take only shorter ones.
  std::size_t max_datagram_bytes = datagram_bytes_max;
  std::uint64_t max_bytes_per_s = 0;  ///< limit of all bytes that are sent; 0: no limit
  Multicast multicast = Multicast::automatic;
  std::size_t send_queue_depth = 4;  ///< number of newest samples that may wait, per writer, mask and address
  ReassemblyLimits reassembly{};     ///< `sample_bytes` is set from max_sample_bytes

  core::ThreadSpec receive_thread = "sft-udp-recv";
  core::ThreadSpec send_thread = "sft-udp-send";
};

/// Wraps the transport's I/O. Tests use it to add loss, delay, repetition and reordering.
using DecorateIo = std::function<DatagramIo(DatagramIo)>;

/// Opens the transport. Received samples are stored in memory of `pool`, which belongs to the node.
Result<std::unique_ptr<core::Network>> open_udp_transport(const UdpOptions& options,
                                                          std::shared_ptr<core::BufferPool> pool,
                                                          const DecorateIo& decorate = {});

}  // namespace sft::udp
