// Limits of the reader's end of a channel (ArrivalWindow), for each writer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ArrivalLimits {
  std::size_t samples = 4096;                      ///< places in the window, from the first missing one on
  std::size_t held_bytes = std::size_t{64} << 20;  ///< memory of whole samples behind a missing one
  std::size_t awaited_bytes = std::size_t{128} << 20;  ///< memory of samples that readers have no room for
  std::size_t ack_bytes = std::size_t{1} << 20;        ///< bytes that are acknowledged without a heartbeat
  std::chrono::milliseconds ask_after{2};              ///< least delay from noticing that a part is missing
  std::chrono::milliseconds ask_again_longest{250};
  /// A sample that has begun is given up and begins anew if neither it nor the first missing sample makes
  /// progress for this time, although the writer is heard. The datagram that began it may have been wrong.
  std::chrono::milliseconds confirm_timeout{300};
  std::chrono::seconds forget_after{5};  ///< silence of the writer after which nothing is asked for
  /// Largest random delay before asking for what other members may miss, too.
  std::chrono::milliseconds spread{8};
  std::uint32_t seed = 1;  ///< seed of the random delays
};

}  // namespace sft::udp
