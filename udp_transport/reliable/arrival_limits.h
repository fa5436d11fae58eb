// Limits of the reader's end of a channel (ArrivalWindow). They hold for each writer separately.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ArrivalLimits {
  /// The maximum number of samples in the window, which begins with the first sample that some reader has
  /// not taken.
  std::size_t samples = 4096;
  /// The maximum memory in bytes of samples that arrived after a missing sample.
  std::size_t held_bytes = std::size_t{64} << 20;
  /// The maximum memory in bytes of samples that wait because the queues of readers are full.
  std::size_t awaited_bytes = std::size_t{128} << 20;
  /// The number of received bytes after which an ack is sent even without a heartbeat.
  std::size_t ack_bytes = std::size_t{1} << 20;
  /// The minimum delay between noticing and requesting a missing part of a sample.
  std::chrono::milliseconds ask_after{2};
  std::chrono::milliseconds ask_again_longest{250};
  /// An incomplete sample is discarded and requested anew if no part of it or of the first missing sample
  /// arrives for this time although datagrams of the writer come. The first datagram of the sample may have
  /// been wrong.
  std::chrono::milliseconds confirm_timeout{300};
  /// Time without a datagram of the writer after which no data is requested.
  std::chrono::seconds forget_after{5};
  /// The maximum random delay of a request for data that other members of a multicast group may miss, too.
  std::chrono::milliseconds spread{8};
  std::uint32_t seed = 1;  ///< seed of the random delays
};

}  // namespace sft::udp
