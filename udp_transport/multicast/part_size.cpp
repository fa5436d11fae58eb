#include "udp_transport/multicast/part_size.h"

#include <algorithm>
#include <utility>

#include "sft/detail/cut.h"

namespace sft::udp {

PartSize::PartSize(const TypeSupport& type, Selection selection) : selection_(std::move(selection)) {
  for (const Selection::Part& part : selection_.parts())
    pieces_.push_back({&part, detail::field_at(type.type(), part.leaf), type.layout_of(part.leaf)});
}

void PartSize::measure(const detail::SampleState& sample) noexcept {
  if (!sample.mask->contains(selection_.mask())) return;
  double less = 0;
  detail::Cut cut;
  for (const Piece& piece : pieces_) {
    const bool is_text = piece.field.member->kind == detail::Kind::string;
    const bool is_sound = is_text ? strings_less(sample, piece, less)
                                  : cut.find(sample, piece.layout, piece.field, *piece.part);
    if (!is_sound) return;
    if (!is_text) less += static_cast<double>(cut.bytes_less());
  }
  const double before = value_.load(std::memory_order_relaxed);
  value_.store(before <= 0 ? less : before + (less - before) / 4, std::memory_order_relaxed);
}

/// Computes the saved bytes of a part of a sequence of strings. Measures only the first strings, and assumes
/// that the others have the same average length.
bool PartSize::strings_less(const detail::SampleState& sample, const Piece& piece, double& bytes) {
  const std::uint32_t begin = __atomic_load_n(sample.index + piece.field.slot, __ATOMIC_RELAXED);
  const detail::Extent all = begin == detail::no_offset ? detail::Extent{} : checked_length(sample, begin);
  if (!all) return false;
  const std::uint32_t looked_at = std::min(all.count, strings_max);
  std::uint64_t at = all.first;
  for (std::uint32_t i = 0; i < looked_at; ++i) {
    const detail::Extent one = checked_length(sample, at);
    if (!one) return false;
    at = std::uint64_t{one.first} + one.count;
    if (at > sample.body_bytes) return false;
  }
  if (looked_at == 0) return true;
  const double each = static_cast<double>(at - all.first) / looked_at;
  bytes += each * (all.count - piece.part->columns.size_of(all.count));
  return true;
}

double PartSize::bytes_less() const { return std::max(0.0, value_.load(std::memory_order_relaxed)); }

}  // namespace sft::udp
