// Reads the datagrams that have come to a socket, one train at a time, with plain calls.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// Used by one thread at a time.
class TrainReader {
 public:
  explicit TrainReader(std::shared_ptr<const UdpSocket> socket);

  /// Reads one train, without waiting. Returns false if there is none. The socket for groups is read last,
  /// unless much of the other one has come in a row: a sender without pauses to the one socket must not keep
  /// others out of the other one.
  bool read(DatagramSink& sink) noexcept;
  /// Reads one train of datagrams to groups, as read() does, even if the process has left all groups.
  bool read_from_groups(DatagramSink& sink) noexcept;

 private:
  static constexpr int trains_in_a_row_max = 16;

  bool read_from(int fd, DatagramSink& sink) noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  std::vector<std::byte> train_;
  int trains_in_a_row_ = 0;  ///< that were read before one of a group was looked for
  alignas(cmsghdr) std::byte control_[train_control_bytes];
};

}  // namespace sft::udp
