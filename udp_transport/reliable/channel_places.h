// Converts ordinals of the present channel to places. An ordinal is a sample's number in its channel. A
// place is its number over all channels of the writer, one channel after the other. They differ by the
// number of samples in the former channels. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sft::udp {

class ChannelPlaces {
 public:
  using Place = std::uint64_t;

  /// Continues with a channel whose next ordinal is `ordinal`, and gives that ordinal the place `place`.
  void begin(std::uint64_t ordinal, Place place) {
    base_ = place - ordinal;
    first_ordinal_ = ordinal;
  }
  /// Returns true if the ordinal is not less than the first followed ordinal.
  bool follows(std::uint64_t ordinal) const { return ordinal >= first_ordinal_; }
  /// Returns the place of that ordinal, or of the first followed ordinal if that is greater.
  Place place_of(std::uint64_t ordinal) const { return base_ + std::max(ordinal, first_ordinal_); }
  std::uint64_t ordinal_of(Place place) const { return place - base_; }
  /// Returns the place of the first ordinal that is followed.
  Place first() const { return place_of(first_ordinal_); }

 private:
  Place base_ = 0;                   ///< place of ordinal 0, modulo 2^64
  std::uint64_t first_ordinal_ = 1;  ///< the first ordinal of the present channel that is followed
};

}  // namespace sft::udp
