// The transport for samples over UDP, which implements the interface of core/seam/transport.h. A transport
// has one receiving socket, one sending socket for each address to which it sends, one receiving thread and
// one sending thread.
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
  automatic,  ///< io_uring if the kernel allows it, otherwise plain sockets
  io_uring,
  sockets,
};

struct UdpOptions {
  std::uint16_t port = 0;          ///< port to which the socket is bound; 0: any free port
  core::IpAddress bind_address{};  ///< default: all addresses of the host, IPv4 and IPv6
  /// Addresses to announce. If it is empty, `bind_address` is announced, or all addresses of the host if
  /// `bind_address` is the default.
  std::vector<core::IpAddress> advertised_addresses{};
  /// Limits the announced addresses of the host to these interfaces, by name, address or network
  /// (interfaces.h). If it is empty, all interfaces that are up are used.
  std::vector<std::string> interfaces{};
  Backend backend = Backend::automatic;

  std::size_t max_sample_bytes = std::size_t{64} << 20;  ///< maximum size of a sent or received body
  /// The requested size of the receive buffer, as the kernel counts; the kernel may grant less.
  std::size_t receive_buffer_bytes = std::size_t{32} << 20;
  /// The size of the send buffer for each address; 0: the system's default. It is small because the queues
  /// of network devices are short, too.
  std::size_t send_buffer_bytes = std::size_t{128} << 10;

  /// The maximum length of a datagram with the SFT header, in bytes. The path to a receiver may carry only
  /// shorter datagrams.
  std::size_t max_datagram_bytes = datagram_bytes_max;
  std::uint64_t max_bytes_per_s = 0;  ///< maximum rate of all sent bytes; 0: no limit
  Multicast multicast = Multicast::automatic;
  std::size_t send_queue_depth = 4;  ///< maximum number of waiting samples per writer, mask and address
  ReassemblyLimits reassembly{};     ///< `sample_bytes` is set from max_sample_bytes

  core::ThreadSpec receive_thread = "sft-udp-recv";
  core::ThreadSpec send_thread = "sft-udp-send";
};

/// A function that wraps the transport's I/O. Tests use it to add loss, delay, repetition and reordering.
using DecorateIo = std::function<DatagramIo(DatagramIo)>;

/// Opens the transport. Received samples are stored in memory of `pool`, which is the node's own memory.
Result<std::unique_ptr<core::Network>> open_udp_transport(const UdpOptions& options,
                                                          std::shared_ptr<core::BufferPool> pool,
                                                          const DecorateIo& decorate = {});

}  // namespace sft::udp
