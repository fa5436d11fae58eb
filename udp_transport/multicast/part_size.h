// The average number of bytes by which a selection with parts of fields makes the samples of one writer
// shorter. It is computed from the lengths in a sample, without encoding the parts.
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
  /// `type` must outlive this object.
  PartSize(const TypeSupport& type, Selection selection);

  const Selection& selection() const { return selection_; }

  /// Measures a sample. Ignores it if it does not have all fields of the selection. Must be called by only
  /// one thread. The value of a new sample gets a weight of one quarter in the average, as for a whole
  /// field. Allocates nothing.
  void measure(const detail::SampleState& sample) noexcept;

  // Any thread may call the following functions.

  /// Returns true if a sample has been measured.
  bool known() const { return value_.load(std::memory_order_relaxed) != unmeasured; }
  /// Returns the number of bytes that the parts save, compared with their whole fields.
  double bytes_less() const;

 private:
  struct Piece {
    const Selection::Part* part = nullptr;
    detail::Layout::Field field{};
    const detail::Layout* layout = nullptr;
  };
  static constexpr std::uint32_t strings_max = 32;  ///< maximum number of measured strings
  static constexpr double unmeasured = -1;

  static bool strings_less(const detail::SampleState& sample, const Piece& piece, double& bytes);

  const Selection selection_;
  std::vector<Piece> pieces_;
  std::atomic<double> value_{unmeasured};
};

}  // namespace sft::udp
