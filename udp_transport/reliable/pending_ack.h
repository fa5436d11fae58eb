// Decides when an ack is due: somebody wants one, or enough has come since the last one. Pure.
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
  /// A sample with so long a body came, or one that nobody here wants.
  void came(std::size_t bytes) {
    bytes_ += bytes;
    ++samples_;
  }
  /// Readers have all before that place: an ack is due if the last one told of less, for their sake.
  void taken(Place place) {
    if (!acked_all_ && acked_ < place) wanted_ = true;
  }
  bool due() const { return wanted_ || bytes_ >= bytes_max_ || samples_ >= acked_at_once; }

  /// An ack is sent that tells of all before `place`; all before `next` has come.
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
