// The receiving socket of a transport, its sending sockets, and the code that both implementations of
// datagram_io.h share: addresses, segmentation, trains of datagrams, waiting.
#pragma once

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <span>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/group_socket.h"
#include "udp_transport/io/interfaces.h"

namespace sft::udp {

using core::FileDescriptor;

struct SocketOptions {
  SocketAddress bind;                    ///< address 0: all addresses of both families; port 0: any free port
  std::size_t receive_buffer_bytes = 0;  ///< requested size, as the kernel counts
  /// Requested size of the send buffer, as the kernel counts; 0: the system's default.
  std::size_t send_buffer_bytes = 0;
  bool hears_groups = false;
};

/// A socket that receives. If it is bound to no particular address, it takes both families (IPv4 as
/// IPv4-mapped), unless the system has no IPv6.
struct UdpSocket {
  FileDescriptor fd;
  int family = AF_INET;  ///< family of the addresses that are passed to the socket
  SocketOptions options;
  std::uint16_t port = 0;
  std::uint32_t receive_buffer_bytes = 0;      ///< granted size, as the kernel counts
  bool receives_trains = false;                ///< true if UDP_GRO is on
  std::string why_no_gro{};                    ///< reason why UDP_GRO is not on; empty if it is on
  std::string why_no_gso{};                    ///< reason why the system has no UDP_SEGMENT; empty if it has
  GroupSocket groups{};                        ///< the group socket; invalid if there is none
  mutable std::atomic<bool> in_groups{false};  ///< true if the group socket may receive datagrams

  /// Returns a descriptor that becomes readable when a datagram has come.
  int readable() const noexcept { return groups.either_fd ? groups.either_fd.get() : fd.get(); }
};

/// Opens a socket that receives. If the port is in use, tries again for some time, because a port can stay
/// in use for a while after its process has ended.
Result<std::shared_ptr<const UdpSocket>> open_udp_socket(const SocketOptions& options);

/// Opens a socket that only sends, to addresses of one family, from any free port and with its own send
/// buffer. The socket is not connected yet. Its datagrams have a high priority if the device supports
/// priorities. The result is invalid if the process cannot open more descriptors.
FileDescriptor open_sending_socket(const SocketOptions& options, int family) noexcept;
/// Lets the kernel divide the datagrams of a connected socket into fragments if its path is known to carry
/// less than the shortest ones that SFT cuts (`datagram_bytes_min`). On all other paths, the kernel refuses
/// datagrams that are too long.
void fit_to_path(int fd) noexcept;
/// Gives the datagrams of this socket a lower priority than those of other sockets.
void give_way(int fd) noexcept;

/// Sends the batches without waiting (sendmmsg()). `to` is null if the socket is connected.
Connection::Sent send_at_once(int fd, std::span<const OutgoingBatch> batches,
                              const SystemAddress* to) noexcept;

/// Returns the outcome that the errno of a failed send means. `segmented` is true if several datagrams were
/// to be sent at once.
SendOutcome outcome_of(int error, bool segmented) noexcept;

/// Opens an eventfd by which other threads wake a thread that waits in a system call. It does not block, and
/// programs that this process starts do not inherit it.
Result<FileDescriptor> open_wake_event();

/// Returns the time that is left until the deadline, in the form that ppoll() takes.
timespec time_until(std::chrono::steady_clock::time_point deadline) noexcept;

/// Calls ppoll() until the deadline or a signal. Returns true if any descriptor is ready; `revents` says
/// which. Otherwise all `revents` are 0.
bool poll_until(std::span<pollfd> polled, std::chrono::steady_clock::time_point deadline) noexcept;

/// The maximum length of a train, which is what the kernel returns by one call (UDP_GRO), and the size of
/// its only control message. Both are in bytes.
inline constexpr std::size_t train_bytes_max = 65536;
inline constexpr std::size_t train_control_bytes = CMSG_SPACE(sizeof(int));

/// Hands the datagrams of a train to the sink, between begin() and end(). `control` has the control messages
/// that came with the train. If they include no segment size, the train is one datagram. `from` is an IPv4
/// or IPv6 address.
void hand_over(std::span<const std::byte> train, std::span<std::byte> control, const sockaddr_in6& from,
               DatagramSink& sink) noexcept;

}  // namespace sft::udp
