#include "sft/cells.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sft/detail/cut.h"
#include "sft/detail/parts_in_place.h"
#include "sft/detail/type_shape.h"
#include "sft/dynamic_view.h"

namespace sft::detail {

CellGrid CellGrid::of(const SampleState& source, const Cut& cut) {
  if (cut.bytes() == 0) return {.rows = cut.rows(), .columns = cut.columns()};
  CellGrid grid{.first = source.body + cut.begin(),
                .row_step = cut.row_stride(),
                .column_step = static_cast<std::uint32_t>(cut.column_stride()),
                .rows = cut.rows(),
                .columns = cut.columns()};
  // If there is only one column or row, the step to the next column or row is not needed, and might not fit
  // into its member.
  if (grid.columns == 1) grid.column_step = cut.cell_bytes();
  if (grid.rows == 1) grid.row_step = grid.row_bytes();
  return grid;
}

namespace {

std::string quoted(const Member& member) { return "'" + std::string(member.name) + "'"; }

tl::unexpected<Error> malformed_cells(const CellsPlace& place) {
  place.sample->flag_malformed();
  return fail(Errc::malformed, quoted(*place.member) + " is not within the bytes of the sample");
}

/// Notes a read of the member. Returns an error if the sample was sent without the member.
Result<void> note_member(const CellsPlace& place, std::size_t leaf, const Member& member) {
  const std::size_t leaves = leaf_count(member);
  const bool was_sent = note_leaves(*place.sample, leaf, leaves);
  if (was_sent && (place.declared == nullptr || place.declared->all_of(leaf, leaves))) return {};
  return fail(Errc::unavailable, quoted(member) + " was not sent in this sample");
}

/// Returns the layout if the field has rows. Otherwise the cells are the elements, whatever the layout says.
const Layout* rows_of(const CellsPlace& place) {
  return place.layout != nullptr && place.layout->has_rows() ? place.layout : nullptr;
}

// All members are noted before an error for a missing member is returned, so that the subscriber requests
// all members at once.
Result<void> note_cells(const CellsPlace& place) {
  Result<void> sent = note_member(place, place.leaf, *place.member);
  const Layout* const layout = rows_of(place);
  if (layout == nullptr) return sent;
  for (const LayoutRole role : {LayoutRole::rows, LayoutRole::columns, LayoutRole::cell_bytes,
                                LayoutRole::row_bytes, LayoutRole::byte_order, LayoutRole::encoding}) {
    const Layout::Field& field = (*layout)[role];
    if (!field) continue;
    if (Result<void> other = note_member(place, field.leaf, *field.member); !other && sent)
      sent = std::move(other);
  }
  return sent;
}

/// Returns true if the byte order differs from that of the machine; nothing if the field for the byte order
/// is not within the sample's bytes.
std::optional<bool> is_swapped(const SampleState& s, const Layout& layout) {
  const Layout::Field& order = layout[LayoutRole::byte_order];
  if (!order) return false;
  const std::size_t bytes = size_of(order.member->kind);
  const std::uint32_t offset = __atomic_load_n(s.index + order.slot, __ATOMIC_RELAXED);
  const std::uint32_t at = offset == no_offset ? no_offset : checked_block(s, offset, 1, bytes);
  if (at == no_offset) return {};
  return std::any_of(s.body + at, s.body + at + bytes, [](std::byte one) { return one != std::byte{0}; });
}

tl::unexpected<Error> other_size(const Member& member, std::size_t bytes, std::size_t cell_bytes) {
  return fail(Errc::type_mismatch, "a cell of " + quoted(member) + " has " + std::to_string(bytes) +
                                       " bytes, not " + std::to_string(cell_bytes));
}

/// Returns the cells of a part, or of a field with rows. `source` is the sample that has the cells.
Result<CellGrid> cells_of_cut(const CellsPlace& place, const SampleState& source, const Cut& cut,
                              std::size_t cell_bytes) {
  if (cut.is_whole())
    return fail(Errc::type_mismatch, quoted(*place.member) + " has no cells of one size in its encoding");
  if (cut.bytes() == 0) return CellGrid();
  if (cut.cell_bytes() != cell_bytes) return other_size(*place.member, cut.cell_bytes(), cell_bytes);
  CellGrid grid = CellGrid::of(source, cut);
  const Layout* const layout = rows_of(place);
  // The field for the byte order only describes cells that are stored as a sequence of bytes. The byte
  // order of elements of several bytes is that of CDR.
  const bool is_of_bytes = size_of(place.member->kind) == 1;
  const std::optional<bool> swapped =
      layout == nullptr || !is_of_bytes ? false : is_swapped(*place.sample, *layout);
  if (!swapped) return malformed_cells(place);
  grid.is_swapped = *swapped;
  return grid;
}

/// Returns all cells of a field. `elements` are the bytes of the field.
Result<CellGrid> cells_of_all(const CellsPlace& place, const SampleState& source,
                              std::span<const std::byte> elements, std::size_t cell_bytes) {
  if (elements.empty()) return CellGrid();
  if (const Layout* const layout = rows_of(place)) {
    const auto data = std::ranges::find(layout->data, place.leaf, &Layout::Field::leaf);
    Cut cut;
    if (!cut.find_all(source, *layout, *data)) return malformed_cells(place);
    return cells_of_cut(place, source, cut, cell_bytes);
  }
  const std::size_t element_bytes = size_of(place.member->kind);
  if (element_bytes != cell_bytes) return other_size(*place.member, element_bytes, cell_bytes);
  return CellGrid{.first = elements.data(),
                  .row_step = elements.size(),
                  .column_step = static_cast<std::uint32_t>(element_bytes),
                  .rows = 1,
                  .columns = static_cast<std::uint32_t>(elements.size() / element_bytes)};
}

/// Returns the bytes of all elements in the body.
std::optional<std::span<const std::byte>> elements_of(const CellsPlace& place) {
  const std::size_t element_bytes = size_of(place.member->kind);
  if (place.offset == no_offset) return {};
  const Extent all = checked_sequence(*place.sample, place.offset, element_bytes);
  if (!all) return {};
  return std::span(place.sample->body + all.first, all.count * element_bytes);
}

}  // namespace

Result<CellGrid> find_cells(const CellsPlace& place, std::size_t cell_bytes) {
  if (place.layout != nullptr && place.layout->has_channels())
    return fail(Errc::type_mismatch,
                "the cells of " + quoted(*place.member) + " have channels: read its points");
  if (const Result<void> sent = note_cells(place); !sent) return tl::unexpected(sent.error());
  const SampleState& s = *place.sample;
  const auto part = s.parts == nullptr ? std::nullopt : s.parts->find(place.leaf);
  if (part && !part->cut->is_whole()) return cells_of_cut(place, *part->source, *part->cut, cell_bytes);
  const auto elements = part ? part->contiguous() : elements_of(place);
  if (!elements) return malformed_cells(place);
  return cells_of_all(place, part ? *part->source : s, *elements, cell_bytes);
}

namespace {

/// Returns the layout of the field with this leaf in a struct with this first leaf and slot. The leaves and
/// slots in the layout are those of the whole sample.
std::optional<Layout> layout_in(const StructType& type, std::size_t first_leaf, std::size_t first_slot,
                                std::size_t leaf) {
  const auto move = [&](Layout::Field& field) {
    field.leaf += static_cast<std::uint32_t>(first_leaf);
    field.slot += static_cast<std::uint32_t>(first_slot);
  };
  for (Layout& layout : layouts_of(type)) {
    std::ranges::for_each(layout.data, move);
    std::ranges::for_each(layout.fields, move);
    if (std::ranges::find(layout.data, leaf, &Layout::Field::leaf) != layout.data.end()) return layout;
  }
  return {};
}

}  // namespace

Result<CellGrid> find_cells(const DynamicView& message, std::string_view path, std::size_t cell_bytes,
                            bool (*holds)(Kind)) {
  const std::size_t dot = path.rfind('.');
  const bool is_nested = dot != std::string_view::npos;
  const DynamicView parent = is_nested ? message.find(path.substr(0, dot)) : message;
  const std::string_view name = is_nested ? path.substr(dot + 1) : path;
  if (parent.error() != nullptr) return tl::unexpected(*parent.error());
  const std::optional<std::size_t> number = parent.number_of(name);
  if (!number) return tl::unexpected(*parent[name].error());
  const Member& member = parent.type_->members[*number];
  if (member.shape != Shape::sequence || !is_primitive(member.kind) || !holds(member.kind)) {
    return fail(Errc::type_mismatch,
                quoted(member) + " is " + format_type(member) + ", which has no cells of that type");
  }
  const DynamicView::Place place = parent.place_of(*number);
  const bool is_indexed = place.slot != DynamicView::no_slot;
  const SampleState& s = *parent.state_;
  const std::optional<Layout> layout =
      is_indexed ? layout_in(*message.type_, message.place_.leaf, message.place_.slot, place.leaf)
                 : std::nullopt;
  return find_cells(
      {.sample = &s,
       .declared = parent.declared_,
       .layout = layout ? &*layout : nullptr,
       .member = &member,
       .leaf = place.leaf,
       .offset = is_indexed ? __atomic_load_n(s.index + place.slot, __ATOMIC_RELAXED) : place.offset},
      cell_bytes);
}

}  // namespace sft::detail
