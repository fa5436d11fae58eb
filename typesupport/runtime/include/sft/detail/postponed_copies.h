// Long runs of primitives that encode() does not copy at once. A transport that sends a body immediately
// can send these runs from the value. The transport copies the runs afterwards, or not at all if the body
// is not needed any more.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sft/detail/project.h"

namespace sft::detail {

/// The postponed copies of one body. They are valid as long as the value exists and does not change.
/// Allocates nothing.
class PostponedCopies {
 public:
  /// The length in bytes below which a run is copied at once.
  static constexpr std::size_t usual_bytes_min = 64 * 1024;

  explicit PostponedCopies(std::size_t bytes_min = usual_bytes_min) : bytes_min_(bytes_min) {}

  /// Adds a copy. Copies are added in their order in the body. Returns false if the bytes have to be copied
  /// now, because the run is short or there are too many copies.
  bool add(std::byte* to, const std::byte* from, std::size_t bytes) noexcept {
    if (bytes < bytes_min_ || count_ == copies_.size()) return false;
    copies_[count_++] = {to, from, bytes};
    return true;
  }

  bool empty() const noexcept { return first_ == count_; }
  void clear() noexcept { first_ = count_ = 0; }

  /// Makes the next copies, of at most this many bytes.
  void make(std::size_t bytes_max) noexcept;
  void make_all() noexcept { make(static_cast<std::size_t>(-1)); }

  /// Returns the address where `bytes` bytes from `data` on can be read at present; null if these bytes are
  /// in several places.
  const std::byte* locate(const std::byte* data, std::size_t bytes) const;

  /// Appends the present addresses of the bytes of these segments, which may refer to the body.
  void locate(std::span<const Segment> segments, std::vector<Segment>& located) const;

 private:
  struct Copy {
    std::byte* to = nullptr;
    const std::byte* from = nullptr;
    std::size_t bytes = 0;
  };
  const std::size_t bytes_min_;
  std::array<Copy, 8> copies_;
  std::size_t first_ = 0;  ///< the index of the first copy that is not made
  std::size_t count_ = 0;
};

}  // namespace sft::detail
