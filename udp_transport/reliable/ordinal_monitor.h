// Decides which ordinals of a channel are believed if they contradict earlier ordinals. One wrong ordinal,
// as by a flipped bit, must not make a reader miss the samples that the writer sends. Uses no clock, thread
// or I/O.
#pragma once

#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace sft::udp {

class OrdinalMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The number of samples of a channel about which it is known if they have come. No writer keeps more
  /// samples.
  static constexpr std::size_t remembered = 8192;
  /// After this number of different samples in a row that the reader had skipped as lost, the reader goes
  /// back to them. Datagrams of the same sample do not count, because a large sample that its writer gave up
  /// may still be under way in many datagrams.
  static constexpr std::uint32_t passed_over_in_a_row = 64;
  /// This number of datagrams of skipped samples is enough if the first and the last are `unconfirmed_after`
  /// apart, and no new sample has come between them. Fewer datagrams may be late repairs. A silence before
  /// the first datagram does not count, because that datagram may have been sent before the silence. A
  /// datagram that was overtaken by later ones of the row neither counts nor ends the row.
  static constexpr std::uint32_t unconfirmed_by = 8;
  static constexpr std::chrono::milliseconds unconfirmed_after{250};
  /// If the same ordinal comes again after this time, it is confirmed, because the writer has sent it twice.
  static constexpr std::chrono::milliseconds repeated_after{10};

  /// Notes that the sample with that ordinal has come, or is not needed.
  void came(std::uint64_t ordinal);
  bool has_come(std::uint64_t ordinal) const;
  /// Notes that an expected sample came.
  void advanced() {
    passed_over_ = 0;
    unconfirmed_ = 0;
  }

  /// Notes that a sample came that had been skipped as lost. If skipping it was wrong, returns the ordinal
  /// to which the reader has to go back.
  std::optional<std::uint64_t> passed_over(std::uint64_t ordinal, bool same_datagram, Time now);
  /// Notes an ordinal that is too far ahead. Returns true if an earlier datagram had an ordinal near it,
  /// which confirms both.
  bool confirmed(std::uint64_t ordinal, bool same_datagram, Time now);

  /// Continues with that ordinal as the next expected one.
  void go_on_with(std::uint64_t ordinal);

 private:
  std::bitset<remembered> came_;
  std::uint64_t came_end_ = 0;  ///< no sample with this ordinal or a greater one has come
  Time passed_over_since_{};
  std::uint32_t passed_over_ = 0;          ///< number of datagrams of skipped samples in a row
  std::uint32_t samples_passed_over_ = 0;  ///< number of different ordinals in that row
  std::uint64_t first_passed_over_ = 0;
  std::uint64_t last_passed_over_ = 0;
  std::uint64_t unconfirmed_ = 0;  ///< an ordinal that needs confirmation; 0: none
  Time unconfirmed_at_{};
};

}  // namespace sft::udp
