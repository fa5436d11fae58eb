// Limits of the reader's end of a channel (ArrivalWindow), for each writer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ArrivalLimits {
  /// Number of places in the window, counted from the first missing one.
  std::size_t samples = 4096;
  /// Limit of the memory of whole samples behind a missing one.
  std::size_t held_bytes = std::size_t{64} << 20;
  /// Limit of the memory of samples for which readers have no room.
  std::size_t awaited_bytes = std::size_t{128} << 20;
  /// Number of bytes after which an ack is sent without a heartbeat.
  std::size_t ack_bytes = std::size_t{1} << 20;
  /// Least delay between noticing and requesting a missing part.
  std::chrono::milliseconds ask_after{2};
  std::chrono::milliseconds ask_again_longest{250};
  /// A sample that has begun to arrive is given up, and begins anew, if neither it nor the first missing
  /// sample makes progress for this time although datagrams of the writer come. The datagram that began the
  /// sample may have been wrong.
  std::chrono::milliseconds confirm_timeout{300};
  std::chrono::seconds forget_after{5};  ///< silence of the writer after which nothing is requested
  /// The largest random delay of a request for data that other members may miss, too.
  std::chrono::milliseconds spread{8};
  std::uint32_t seed = 1;  ///< seed of the random delays
};

}  // namespace sft::udp
