// Decides which ordinals of a channel are believed, where they contradict what is known. One wrong number
// must not keep a reader from the samples that the writer sends. Pure: numbers and times in, answers out.
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
  /// After so many samples in a row that were passed over, and had not come, the reader goes back. (One large
  /// sample that its writer gave up may still be under way in many datagrams.)
  static constexpr std::uint32_t passed_over_in_a_row = 64;
  /// So many datagrams suffice if the first and the last are so far apart, and nothing new has come between
  /// them: fewer may be repairs that come late. A silence before them does not count: after it the first to
  /// come may be what was sent before it. One that others of the row have overtaken neither counts nor ends
  /// it.
  static constexpr std::uint32_t unconfirmed_by = 8;
  static constexpr std::chrono::milliseconds unconfirmed_after{250};
  /// A repetition of the same ordinal confirms it if it comes so much later: the writer sent it twice.
  static constexpr std::chrono::milliseconds repeated_after{10};

  /// Something of that sample has come, and it needs not come again.
  void came(std::uint64_t ordinal);
  bool has_come(std::uint64_t ordinal) const;
  /// Something came that was expected.
  void advanced() {
    passed_over_ = 0;
    unconfirmed_ = 0;
  }

  /// A sample came that was passed over. Returns the ordinal to go back to, if it was wrong to do that.
  std::optional<std::uint64_t> passed_over(std::uint64_t ordinal, bool same_datagram, Time now);
  /// Returns true if an earlier datagram has claimed an ordinal near this one, out of reach as well.
  bool confirmed(std::uint64_t ordinal, bool same_datagram, Time now);

  /// Takes that ordinal as the next one.
  void go_on_with(std::uint64_t ordinal);

 private:
  std::bitset<remembered> came_;
  std::uint64_t came_end_ = 0;  ///< none from here on has come
  Time passed_over_since_{};
  std::uint32_t passed_over_ = 0;          ///< datagrams in a row
  std::uint32_t samples_passed_over_ = 0;  ///< of these, with different ordinals
  std::uint64_t first_passed_over_ = 0;
  std::uint64_t last_passed_over_ = 0;
  std::uint64_t unconfirmed_ = 0;  ///< an ordinal that waits to be confirmed; 0: none
  Time unconfirmed_at_{};
};

}  // namespace sft::udp
