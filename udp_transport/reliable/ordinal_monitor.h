// Decides which ordinals of a channel count if they contradict earlier ones. One wrong number must not keep
// a reader from the samples that the writer sends. Uses no clock, thread or I/O.
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

  /// The number of samples of a channel that are remembered; no writer keeps more.
  static constexpr std::size_t remembered = 8192;
  /// The number of different samples in a row that were passed over, and had not come, after which the
  /// reader goes back. (One large sample that its writer gave up may still be under way in many datagrams.)
  static constexpr std::uint32_t passed_over_in_a_row = 64;
  /// This many datagrams are enough if the first and the last are `unconfirmed_after` apart, and no new
  /// sample has come between them; fewer may be late repairs. A silence before them does not count, because
  /// the datagram after it may have been sent before it. A datagram that later ones of the row have
  /// overtaken neither counts nor ends the row.
  static constexpr std::uint32_t unconfirmed_by = 8;
  static constexpr std::chrono::milliseconds unconfirmed_after{250};
  /// An ordinal confirms itself if it comes again this much later, because the writer has sent it twice.
  static constexpr std::chrono::milliseconds repeated_after{10};

  /// Notes that the sample with that ordinal is not needed again.
  void came(std::uint64_t ordinal);
  bool has_come(std::uint64_t ordinal) const;
  /// Notes that an expected sample came.
  void advanced() {
    passed_over_ = 0;
    unconfirmed_ = 0;
  }

  /// Notes that a sample came that had been passed over. If passing over was wrong, returns the ordinal to
  /// go back to.
  std::optional<std::uint64_t> passed_over(std::uint64_t ordinal, bool same_datagram, Time now);
  /// Returns true if an earlier datagram had an ordinal near this one, which was out of reach as well.
  bool confirmed(std::uint64_t ordinal, bool same_datagram, Time now);

  /// Continues with that ordinal.
  void go_on_with(std::uint64_t ordinal);

 private:
  std::bitset<remembered> came_;
  std::uint64_t came_end_ = 0;  ///< no sample with this ordinal or a greater one has come
  Time passed_over_since_{};
  std::uint32_t passed_over_ = 0;          ///< number of datagrams of passed-over samples in a row
  std::uint32_t samples_passed_over_ = 0;  ///< number of different ordinals in this row
  std::uint64_t first_passed_over_ = 0;
  std::uint64_t last_passed_over_ = 0;
  std::uint64_t unconfirmed_ = 0;  ///< an ordinal that needs confirmation; 0: none
  Time unconfirmed_at_{};
};

}  // namespace sft::udp
