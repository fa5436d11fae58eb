// The sockets of a transport: the one that receives, those that send, and what all ways of using them share:
// addresses, segmentation, trains of datagrams.
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
  SocketAddress bind;                    ///< address 0: all, of both families; port 0: any
  std::size_t receive_buffer_bytes = 0;  ///< wanted, as the kernel counts
  std::size_t send_buffer_bytes = 0;     ///< 0: the system's default
  bool hears_groups = false;
};

/// Not bound to an address it takes both families, IPv4 as IPv4-mapped, unless the system has no IPv6.
struct UdpSocket {
  FileDescriptor fd;
  int family = AF_INET;  ///< of the addresses that it is used with
  SocketOptions options;
  std::uint16_t port = 0;
  std::uint32_t receive_buffer_bytes = 0;      ///< granted, as the kernel counts
  bool receives_trains = false;                ///< UDP_GRO is on
  std::string why_no_gro{};                    ///< unless it is
  std::string why_no_gso{};                    ///< empty: the system has UDP_SEGMENT
  GroupSocket groups{};                        ///< invalid where there can be none
  mutable std::atomic<bool> in_groups{false};  ///< the group socket may receive something

  /// Becomes readable when something has come.
  int readable() const noexcept { return groups.either_fd ? groups.either_fd.get() : fd.get(); }
};

/// A port that a process just left can stay in use for some 50 ms; this waits for it.
Result<std::shared_ptr<const UdpSocket>> open_udp_socket(const SocketOptions& options);

/// One that sends only, to addresses of one family, from any free port and with a send buffer of its own; not
/// connected yet. Where a device has a choice, what it sends goes first. Invalid where the process may not
/// open more.
FileDescriptor open_sending_socket(const SocketOptions& options, int family) noexcept;
/// From now on the datagrams of other sockets go first.
void give_way(int fd) noexcept;

/// sendmmsg() that never waits. `to` is null where the socket is connected.
Connection::Sent send_at_once(int fd, std::span<const OutgoingBatch> batches,
                              const SystemAddress* to) noexcept;

/// Returns what a failed send means, by its errno; `segmented` if several datagrams were sent.
SendOutcome outcome_of(int error, bool segmented) noexcept;

/// Returns the time that is left until then, as ppoll() takes it.
timespec time_until(std::chrono::steady_clock::time_point deadline) noexcept;

/// ppoll() until then, or a signal. Whether any is ready; `revents` says which, and nothing otherwise.
bool poll_until(std::span<pollfd> polled, std::chrono::steady_clock::time_point deadline) noexcept;

/// The longest train that the kernel hands over at a time (UDP_GRO), and room for its one control message.
inline constexpr std::size_t train_bytes_max = 65536;
inline constexpr std::size_t train_control_bytes = CMSG_SPACE(sizeof(int));

/// Hands the datagrams of a train to the sink, between begin() and end(). `control` are the control messages
/// that came with it; without the segment size among them the train is one datagram. `from` is of either
/// family.
void hand_over(std::span<const std::byte> train, std::span<std::byte> control, const sockaddr_in6& from,
               DatagramSink& sink) noexcept;

}  // namespace sft::udp
