// The one socket of a transport, and what both ways of using it share:
// addresses, segmentation, trains of datagrams.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "sft/typesupport/result.h"
#include "udp_transport/datagram_io.h"

namespace sft::udp {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileDescriptor();
  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }

 private:
  int release() { return std::exchange(fd_, -1); }
  int fd_;
};

struct SocketOptions {
  SocketAddress bind;                    ///< address 0: all; port 0: any
  std::size_t receive_buffer_bytes = 0;  ///< wanted, as the kernel counts
  std::size_t send_buffer_bytes = 0;     ///< 0: the system's default
};

struct UdpSocket {
  FileDescriptor fd;
  std::uint16_t port = 0;
  std::uint32_t receive_buffer_bytes = 0;  ///< granted, as the kernel counts
  bool receives_trains = false;            ///< UDP_GRO is on
};

/// A port that a process just left can stay in use for some 50 ms; this waits for it.
Result<std::shared_ptr<const UdpSocket>> open_udp_socket(const SocketOptions& options);

/// One batch as sendmsg() takes it. Points into itself: stays where it is until the kernel has it.
class OutgoingMessage {
 public:
  void set(const OutgoingBatch& batch) noexcept;
  const msghdr& header() const { return header_; }

 private:
  msghdr header_{};
  sockaddr_in to_{};
  alignas(cmsghdr) std::byte control_[CMSG_SPACE(sizeof(std::uint16_t))]{};
};

/// What a failed send means, by its errno.
SendOutcome outcome_of(int error) noexcept;

/// Room for the one control message that receiving with UDP_GRO brings.
inline constexpr std::size_t train_control_bytes = CMSG_SPACE(sizeof(int));

/// Hands the datagrams of a train to the sink, between begin() and end(). `control` are the control messages
/// that came with it; without the segment size among them the train is one datagram.
void hand_over(std::span<const std::byte> train, std::span<std::byte> control, const sockaddr_in& from,
               DatagramSink& sink) noexcept;

}  // namespace sft::udp
