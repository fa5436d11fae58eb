// Datagrams through plain socket calls, for kernels and containers that refuse io_uring. The throughput is
// that of io_uring, since it depends on segmentation (GSO, GRO). But each wake-up costs one more system
// call.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// Each call to the system reads one train: several datagrams of one sender, which the kernel has joined
/// (UDP_GRO).
class SocketReceiver final : public DatagramReceiver {
 public:
  /// `wake_event` is an eventfd that does not block.
  SocketReceiver(std::shared_ptr<const UdpSocket> socket, FileDescriptor wake_event);

  bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept override;
  void wake() noexcept override;
  void finish() noexcept override {}
  bool receive_now(DatagramSink& sink) noexcept override;
  bool receive_from_groups(DatagramSink& sink) noexcept override;
  Descriptors descriptors() const noexcept override { return {socket_->readable(), wake_event_.get()}; }

 private:
  bool read_from(int fd, DatagramSink& sink) noexcept;
  bool was_woken() noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  const FileDescriptor wake_event_;
  std::vector<std::byte> train_;
  int trains_in_a_row_ = 0;  ///< number of unicast trains since the socket for groups was read
  alignas(cmsghdr) std::byte control_[train_control_bytes];
  std::atomic<bool> woken_{false};  ///< set by wake(), and read by a thread that spins
};

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
