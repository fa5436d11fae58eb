// Reads the datagrams that have come to a socket with plain system calls. Each call reads one train: several
// datagrams of one sender, which the kernel has joined (UDP_GRO).
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// A reader object may be used by only one thread at a time.
class TrainReader {
 public:
  explicit TrainReader(std::shared_ptr<const UdpSocket> socket);

  /// Reads one train, without waiting. Returns false if there is none. Tries the unicast socket first. After
  /// many unicast trains in a row, tries the socket for groups first once. Otherwise a unicast sender that
  /// never pauses would block that socket.
  bool read(DatagramSink& sink) noexcept;
  /// Reads one train of datagrams that were sent to multicast groups, without waiting. Also reads trains
  /// that came before the process left all groups. Returns false if there is no train.
  bool read_from_groups(DatagramSink& sink) noexcept;

 private:
  static constexpr int trains_in_a_row_max = 16;

  bool read_from(int fd, DatagramSink& sink) noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  std::vector<std::byte> train_;
  int trains_in_a_row_ = 0;  ///< number of unicast trains since the socket for groups was read
  alignas(cmsghdr) std::byte control_[train_control_bytes];
};

}  // namespace sft::udp
