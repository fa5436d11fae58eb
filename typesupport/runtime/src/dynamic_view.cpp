#include "sft/dynamic_view.h"

#include <algorithm>
#include <charconv>

#include "sft/detail/parts_in_place.h"
#include "sft/detail/text.h"
#include "sft/detail/type_shape.h"

namespace sft {

using namespace detail;

namespace {

using Scalar = DynamicView::Scalar;

/// Returns the offset at which a string ends, and the next string of a collection begins.
std::uint64_t behind_string(const SampleState& s, std::uint64_t offset) {
  const Extent length = checked_length(s, offset);
  return length ? checked_block(s, length.first + std::uint64_t{length.count}, 0, 1) : no_offset;
}

template <class V, class Wide>
Scalar widened(const std::byte* at) {
  V value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<Wide>(value);
}

Scalar load(Kind kind, const std::byte* at) {
  switch (kind) {
    case Kind::boolean:
      return *at != std::byte{0};
    case Kind::character:
      return widened<char, char>(at);
    case Kind::int8:
      return widened<std::int8_t, std::int64_t>(at);
    case Kind::int16:
      return widened<std::int16_t, std::int64_t>(at);
    case Kind::int32:
      return widened<std::int32_t, std::int64_t>(at);
    case Kind::int64:
      return widened<std::int64_t, std::int64_t>(at);
    case Kind::octet:
    case Kind::uint8:
      return widened<std::uint8_t, std::uint64_t>(at);
    case Kind::uint16:
      return widened<std::uint16_t, std::uint64_t>(at);
    case Kind::uint32:
      return widened<std::uint32_t, std::uint64_t>(at);
    case Kind::uint64:
      return widened<std::uint64_t, std::uint64_t>(at);
    case Kind::float32:
      return widened<float, float>(at);
    case Kind::float64:
      return widened<double, double>(at);
    case Kind::string:
    case Kind::structure:
      break;
  }
  return false;
}

std::string nearest_member(const StructType& type, std::string_view name) {
  const auto distance = [&](const Member& m) { return edit_distance(m.name, name); };
  const auto nearest =
      std::min_element(type.members.begin(), type.members.end(),
                       [&](const Member& a, const Member& b) { return distance(a) < distance(b); });
  return nearest == type.members.end() ? "" : "; did you mean '" + std::string(nearest->name) + "'?";
}

std::optional<std::string> symbol(const EnumType& type, std::uint64_t value) {
  std::string flags;
  for (const Enumerator& e : type.enumerators) {
    if (!type.is_bitmask && e.value == value) return std::string(e.name);
    if (!type.is_bitmask || (value & e.value) == 0) continue;
    flags += (flags.empty() ? "" : " | ") + std::string(e.name);
    value &= ~e.value;
  }
  if (value != 0 || flags.empty()) return std::nullopt;
  return flags;
}

}  // namespace

DynamicView::DynamicView(const SampleState& s, const StructType& type)
    : state_(&s), type_(&type), node_(Node::structure) {
  if (s.index != nullptr) place_.slot = 0;
}

DynamicView::DynamicView(const SampleState& s, const StructType& type, const FieldMask& declared)
    : DynamicView(s, type) {
  declared_ = &declared;
}

// ---- navigation ----

DynamicView DynamicView::operator[](std::string_view member) const {
  if (error_ != nullptr) return *this;
  if (!is_struct()) return failed(Errc::type_mismatch, label() + " has no members: it is no struct");
  const std::optional<std::size_t> number = number_of(member);
  if (!number) {
    return failed(Errc::unknown_field, std::string(type_->name) + " has no member '" + std::string(member) +
                                           "'" + nearest_member(*type_, member));
  }
  return member_at(type_->members[*number], place_of(*number));
}

std::optional<std::size_t> DynamicView::number_of(std::string_view member) const {
  if (!is_struct()) return {};
  const auto found = std::ranges::find(type_->members, member, &Member::name);
  if (found == type_->members.end()) return {};
  return static_cast<std::size_t>(found - type_->members.begin());
}

DynamicView DynamicView::find(std::string_view path) const {
  DynamicView at = *this;
  while (!path.empty() && at.error_ == nullptr) {
    if (path.front() == '[') {
      std::size_t i = 0;
      const auto [end, error] = std::from_chars(path.data() + 1, path.data() + path.size(), i);
      if (error != std::errc{} || end == path.data() + path.size() || *end != ']')
        return failed(Errc::unknown_field, "not a path: '" + std::string(path) + "'");
      at = at.element(i);
      path.remove_prefix(static_cast<std::size_t>(end - path.data()) + 1);
    } else {
      const std::size_t end = std::min(path.find_first_of(".["), path.size());
      at = at[path.substr(0, end)];
      path.remove_prefix(end);
    }
    if (path.starts_with('.')) path.remove_prefix(1);
  }
  return at;
}

/// Returns the place of member number `member`: its slot, or the offset at which the previous member ends.
DynamicView::Place DynamicView::place_of(std::size_t member) const {
  Place place = place_;
  place.leaf += leaf_offset(*type_, member);
  if (place.slot != no_slot) {
    place.slot += slot_offset(*type_, member);
  } else if (present_) {
    place.offset = member_begin(*state_, *type_, member, place_.leaf, place_.offset);
  }
  return place;
}

/// Moves `place` from a member to the next member.
void DynamicView::pass(const Member& m, Place& place) const {
  if (place.slot != no_slot) {
    place.slot += slot_count(m);
  } else if (present_ && place.offset != no_offset) {
    place.offset = skip(*state_, m, place.leaf, place.offset);
  }
  place.leaf += leaf_count(m);
}

DynamicView DynamicView::member_at(const Member& m, const Place& place) const {
  DynamicView view(state_, declared_, m);
  view.type_ = m.type;
  view.place_ = place;
  const bool is_single_struct = m.kind == Kind::structure && m.shape == Shape::single;
  view.present_ = present_ && has_any_of(place.leaf, leaf_count(m)) &&
                  (is_single_struct || is_as_published(place.leaf, leaf_count(m)));
  view.node_ = is_single_struct ? Node::structure : m.shape == Shape::single ? Node::value : Node::collection;
  if (!view.present_) return view;
  if (place.slot != no_slot && !is_single_struct) {
    view.is_in_place_ = state_->parts != nullptr && state_->parts->find(place.leaf).has_value();
    if (view.is_in_place_)
      // The slot is kept, because the field is found by its slot in the sample that is put together.
      return view;
    view.place_.slot = no_slot;
    view.place_.offset = __atomic_load_n(state_->index + place.slot, __ATOMIC_RELAXED);
  }
  return view.place_.slot == no_slot && view.place_.offset == no_offset ? view.malformed() : view;
}

/// Returns this view of the sample with all parts put together. In that sample, elements can be read one by
/// one.
DynamicView DynamicView::put_together() const {
  const SampleState& whole = state_->parts->put_together();
  if (whole.body == nullptr) return malformed();
  DynamicView view = *this;
  view.state_ = &whole;
  view.is_in_place_ = false;
  view.place_.offset = __atomic_load_n(whole.index + place_.slot, __ATOMIC_RELAXED);
  view.place_.slot = no_slot;
  return view;
}

DynamicView DynamicView::element(std::size_t i) const {
  if (error_ != nullptr) return *this;
  if (is_in_place_) return put_together().element(i);
  if (!is_collection()) return failed(Errc::type_mismatch, label() + " is neither array nor sequence");
  if (!present_) return element_at(0);
  const Extent all = extent();
  if (!all) return malformed();
  if (i >= all.count) {
    return failed(Errc::invalid_argument,
                  label() + " has " + std::to_string(all.count) + " elements; they begin with [0]");
  }
  if (is_primitive(kind())) return element_at(all.first + i * size_of(kind()));
  std::uint64_t at = all.first;
  for (std::size_t before = 0; before < i && at != no_offset; ++before) {
    const std::uint64_t next = behind_element(at);
    if (next == at) break;  // ends the loop, since elements without bytes all have the same offset
    at = next;
  }
  return at == no_offset ? malformed() : element_at(at);
}

DynamicView DynamicView::element_at(std::uint64_t offset) const {
  DynamicView view(state_, declared_, *member_);
  view.type_ = type_;
  view.place_.offset = offset;
  view.place_.leaf = element_leaf();
  view.node_ = kind() == Kind::structure ? Node::structure : Node::value;
  view.present_ = present_ && !has_only_size();
  return view;
}

std::uint64_t DynamicView::behind_element(std::uint64_t offset) const {
  if (is_primitive(kind())) return offset + size_of(kind());
  if (kind() == Kind::string) return behind_string(*state_, offset);
  return skip(*state_, *type_, element_leaf(), offset);
}

/// Returns the first leaf of the elements. A sequence of structs has one more leaf before it, for its
/// length.
std::size_t DynamicView::element_leaf() const {
  return place_.leaf + (kind() == Kind::structure && shape() == Shape::sequence ? 1 : 0);
}

bool DynamicView::has_only_size() const {
  return is_collection() && kind() == Kind::structure && present_ &&
         !has_any_of(element_leaf(), leaf_count(*type_));
}

DynamicView::Elements::Elements(DynamicView of) : of_(std::move(of)) {
  if (of_.is_in_place_) {
    of_ = of_.put_together();
    if (of_.error_ != nullptr) left_ = 1;  // the view then has one element, which reports the error
  }
  if (!of_ || !of_.is_collection()) return;
  const bool empty_ones = of_.has_only_size();
  if (empty_ones && of_.state_->log == nullptr) return;
  const Extent all = of_.extent();
  left_ = all ? all.count : 1;  // a malformed sequence has one element, which reports the error
  if (empty_ones) left_ = std::min<std::size_t>(left_, max_empty_elements);
  first_ = all.first;
}

// ---- values ----

/// Returns the contiguous bytes of a part in place.
Result<std::span<const std::byte>> DynamicView::part() const {
  note();
  const auto bytes = bytes_in_place(*state_, place_.leaf);
  if (!bytes || bytes->data() == nullptr) return tl::unexpected(*malformed().error_);
  return *bytes;
}

/// Returns the offset of the first element of a collection, and the number of elements. Both are checked
/// against the bytes of the sample.
Extent DynamicView::extent() const {
  note();
  const Member& m = *member_;
  const std::uint64_t offset = place_.offset;
  if (m.shape == Shape::sequence) {
    return is_primitive(m.kind) ? checked_sequence(*state_, offset, size_of(m.kind))
                                : checked_length(*state_, offset);
  }
  if (is_primitive(m.kind)) return {checked_block(*state_, offset, m.count, size_of(m.kind)), m.count};
  return {checked_block(*state_, offset, 0, 1), m.count};
}

Result<std::size_t> DynamicView::size() const {
  if (!is_collection() || !*this) return tl::unexpected(not_readable("an array or a sequence"));
  if (is_in_place_) return part().map([this](auto bytes) { return bytes.size() / size_of(kind()); });
  const Extent all = extent();
  if (!all) return tl::unexpected(*malformed().error_);
  return all.count;
}

Result<DynamicView::Scalar> DynamicView::scalar() const {
  if (node_ != Node::value || !*this) return tl::unexpected(not_readable("a single value"));
  if (kind() == Kind::string) {
    const Extent text = checked_string(*state_, place_.offset);
    if (!text) return tl::unexpected(*malformed().error_);
    return std::string_view(reinterpret_cast<const char*>(state_->body + text.first), text.count);
  }
  const std::uint32_t at = checked_block(*state_, place_.offset, 1, size_of(kind()));
  if (at == no_offset) return tl::unexpected(*malformed().error_);
  return load(kind(), state_->body + at);
}

std::optional<std::string> DynamicView::enumerator() const {
  if (member_ == nullptr || member_->enumeration == nullptr) return std::nullopt;
  const Result<std::uint64_t> value = as<std::uint64_t>();
  return value ? symbol(*member_->enumeration, *value) : std::nullopt;
}

Result<std::span<const std::byte>> DynamicView::primitives(std::size_t element_bytes, const char* wanted,
                                                           bool (*matches)(Kind)) const {
  if (!is_collection() || !*this || !matches(kind())) return tl::unexpected(not_readable(wanted));
  if (is_in_place_) return part();
  const Extent all = extent();
  if (!all) return tl::unexpected(*malformed().error_);
  return std::span(state_->body + all.first, all.count * element_bytes);
}

// ---- errors ----

std::string DynamicView::label() const {
  return member_ == nullptr ? "the sample" : "'" + std::string(member_->name) + "'";
}

DynamicView DynamicView::failed(Errc code, std::string message) const {
  DynamicView view = *this;
  view.error_ = std::make_shared<const Error>(Error{code, std::move(message)});
  return view;
}

DynamicView DynamicView::malformed() const {
  state_->flag_malformed();
  return failed(Errc::malformed, label() + " is not within the bytes of the sample");
}

Error DynamicView::not_readable(const char* wanted) const {
  if (error_ != nullptr) return *error_;
  if (!present_) return {Errc::unavailable, label() + " was not sent in this sample"};
  const std::string what =
      member_ == nullptr || kind() == Kind::structure ? std::string(type_->name) : format_type(*member_);
  return {Errc::type_mismatch, label() + " is " + what + ", not " + wanted};
}

}  // namespace sft
