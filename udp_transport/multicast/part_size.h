// The bytes that a selection with parts leaves out of the samples of one writer, on average. They follow from
// the numbers that a sample says of itself, without a projection.
#pragma once

#include <atomic>
#include <vector>

#include "sft/detail/layout.h"
#include "sft/detail/walk.h"
#include "sft/selection.h"
#include "sft/type_support.h"

namespace sft::udp {

class PartSize {
 public:
  /// `type` outlives it.
  PartSize(const TypeSupport& type, Selection selection);

  const Selection& selection() const { return selection_; }

  /// One thread: notes a sample that has all fields of the selection, and ignores others. Each new average
  /// counts for a quarter, as that of a whole field does. Allocates nothing.
  void measure(const detail::SampleState& sample) noexcept;

  // Any thread.

  /// A sample has been measured.
  bool known() const { return value_.load(std::memory_order_relaxed) != unmeasured; }
  /// Returns what the parts have less than their fields have as a whole.
  double bytes_less() const;

 private:
  struct Piece {
    const Selection::Part* part = nullptr;
    detail::Layout::Field field{};
    const detail::Layout* layout = nullptr;
  };
  static constexpr std::uint32_t strings_max = 32;  ///< that are looked at
  static constexpr double unmeasured = -1;

  static bool strings_less(const detail::SampleState& sample, const Piece& piece, double& bytes);

  const Selection selection_;
  std::vector<Piece> pieces_;
  std::atomic<double> value_{unmeasured};
};

}  // namespace sft::udp
