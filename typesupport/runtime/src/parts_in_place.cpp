#include "sft/detail/parts_in_place.h"

#include "gather.h"

namespace sft::detail {

std::optional<std::span<const std::byte>> bytes_in_place(const SampleState& s, std::size_t leaf) noexcept {
  const auto bytes = s.parts->bytes_of(leaf);
  if (bytes && bytes->data() == nullptr) s.flag_malformed();
  return bytes;
}

const SampleState& put_together(const SampleState& s) noexcept { return s.parts->put_together(); }

std::optional<std::span<const std::byte>> PartInPlace::contiguous() const noexcept {
  if (cut->is_whole()) {
    const std::size_t element_bytes = size_of(data.member->kind);
    const std::uint32_t offset = __atomic_load_n(source->index + data.slot, __ATOMIC_RELAXED);
    const Extent all = checked_sequence(*source, offset, element_bytes);
    if (!all) return {};
    return std::span(source->body + all.first, all.count * element_bytes);
  }
  if (cut->bytes() == 0) return std::span(source->body, 0);
  const bool has_whole_cells = cut->runs().size() == 1 && cut->runs()[0].bytes == cut->column_stride();
  const bool has_one_cell = cut->runs().size() == 1 && cut->columns() == 1;
  const std::uint64_t row_bytes = std::uint64_t{cut->columns()} * cut->cell_bytes();
  const bool has_whole_rows = cut->rows() == 1 || row_bytes == cut->row_stride();
  if (!has_whole_rows || (!has_whole_cells && !has_one_cell)) return {};
  return std::span(source->body + cut->begin() + cut->runs()[0].offset, cut->bytes());
}

void PartInPlace::gather_to(std::byte* to) const noexcept { gather(*cut, to, source->body + cut->begin()); }

}  // namespace sft::detail
