// Decides when an ack is due: if an ack was requested, or if a certain amount of data has come since the
// last ack. Uses no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sft::udp {

class PendingAck {
 public:
  using Place = std::uint64_t;

  static constexpr std::size_t acked_at_once = 1024;

  explicit PendingAck(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  void want() { wanted_ = true; }
  /// Notes that a sample came. `bytes` is the length of its body, or 0 if no reader of this process needs
  /// the sample.
  void came(std::size_t bytes) {
    bytes_ += bytes;
    ++samples_;
  }
  /// Notes that readers have taken all samples before that place. An ack is due if the last ack did not
  /// cover these samples because readers had not taken them.
  void taken(Place place) {
    if (!acked_all_ && acked_ < place) wanted_ = true;
  }
  bool due() const { return wanted_ || bytes_ >= bytes_max_ || samples_ >= acked_at_once; }

  /// Notes that an ack is sent for all samples before `place`. `next` is the place of the first sample that
  /// has not come.
  void sent(Place place, Place next) {
    wanted_ = false;
    bytes_ = 0;
    samples_ = 0;
    acked_ = place;
    acked_all_ = place == next;
  }

 private:
  const std::size_t bytes_max_;
  bool wanted_ = false;
  std::size_t bytes_ = 0;
  std::size_t samples_ = 0;
  Place acked_ = 1;
  bool acked_all_ = true;
};

}  // namespace sft::udp
