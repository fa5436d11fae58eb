// Reads a sample by the names of its fields, without the compiled type. DynamicSample::view() returns a view.
// A value is decoded only when it is read.
//
//   const sft::DynamicView cloud = sample.view();
//   cloud["header"]["stamp"]["sec"].as<std::int32_t>()      -> Result<std::int32_t>
//   cloud.find("fields[1].name").as<std::string_view>()
//   for (const DynamicView& field : cloud["fields"].elements()) ...
//
// Navigation always returns a view, which is in one of three states:
//   - readable: the view converts to true
//   - absent: the sample was sent without the field; reading its value is an error, never zero
//   - erroneous: error() is not null, because there is no such field or element, or because the bytes are
//     malformed (then the sample is flagged, too)
//
// If the subscriber records which fields the program reads, both reading the value of a view and testing if
// the view is true count as accesses to the field. For a struct, this is an access to its first leaf. A call
// of is_absent() is no access.
//
// A view owns nothing. It must not outlive the sample and the type to which it refers. Several threads may
// read one sample. Errors of a read are values (result.h); no function throws.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "sft/detail/element_type.h"
#include "sft/detail/outlives_view.h"
#include "sft/detail/walk.h"
#include "sft/result.h"

namespace sft {

class DynamicView;

namespace detail {
struct CellGrid;
struct CloudPlace;
struct WantedChannel;
Result<CloudPlace> cloud_place_of(const DynamicView& view, std::span<const WantedChannel> wanted);
Result<CellGrid> find_cells(const DynamicView& message, std::string_view path, std::size_t cell_bytes,
                            bool (*holds)(Kind));
}  // namespace detail

/// A sample or a part of it: a struct, an array or a sequence, or one value.
/// Larger than usual: it has a getter for each kind of value.
class DynamicView {
 public:
  class Members;
  class Elements;
  /// One primitive or string. Integers of all widths and octets are widened; an enumeration is its integer.
  using Scalar = std::variant<bool, char, std::int64_t, std::uint64_t, float, double, std::string_view>;

  /// For SFT's own code: makes the view of a whole sample of `type`. `s.index` may be null: then members
  /// are found by walking.
  DynamicView(const detail::SampleState& s, const StructType& type);
  /// Makes the view for a reader that declared fewer fields than the sample may have. All other fields are
  /// absent. `declared` must be closed (TypeSupport::closed) and outlive the view.
  DynamicView(const detail::SampleState& s, const StructType& type, const FieldMask& declared);

  // ---- navigation ----

  /// Returns a member of a struct.
  DynamicView operator[](std::string_view member) const;
  /// Returns an element of an array or a sequence, counted from 0. If the elements are strings or structs,
  /// a call walks over all previous elements. Use elements() to read all of them.
  template <std::integral I>
  DynamicView operator[](I i) const {
    return element(std::in_range<std::size_t>(i) ? static_cast<std::size_t>(i) : SIZE_MAX);
  }
  /// Returns the value at a path: "header.stamp.sec", "fields[1].name".
  DynamicView find(std::string_view path) const;
  /// Returns all members of a struct in order, including absent ones; none if the view is not a struct.
  Members members() const;
  /// Returns all elements of an array or a sequence; none if the view is neither. If only the length of a
  /// sequence was sent, the result is empty. If the subscriber records which fields are read, the result
  /// instead has absent elements, so that the missing fields can be noted. If the bytes end early, the last
  /// element is an error.
  Elements elements() const;

  // ---- kind and type ----

  /// Returns true if the value can be read: it was sent, and its bytes are valid.
  explicit operator bool() const {
    note();
    return error_ == nullptr && present_;
  }
  /// Returns true if the sample was sent without this field.
  bool is_absent() const { return error_ == nullptr && !present_; }
  /// Returns the error of the view; null if the view has no error. The error is valid as long as the view.
  const Error* error() const { return error_.get(); }

  /// Returns true for a struct, even if it is an element.
  bool is_struct() const { return node_ == Node::structure; }
  /// Returns true for a whole array or sequence.
  bool is_collection() const { return node_ == Node::collection; }
  /// Returns the kind of a value, or of the elements of an array or a sequence.
  StructType::Member::Kind kind() const {
    return member_ == nullptr ? detail::Kind::structure : member_->kind;
  }
  /// Returns array or sequence if the view is a collection, otherwise single.
  StructType::Member::Shape shape() const { return is_collection() ? member_->shape : detail::Shape::single; }
  /// Returns the member that the view shows, or of which it shows an element; null for the whole sample.
  const StructType::Member* member() const { return member_; }
  /// Returns the name of member(); empty for the whole sample.
  SFT_OUTLIVES_VIEW std::string_view name() const {
    return member_ == nullptr ? std::string_view() : member_->name;
  }
  /// Returns the type of a struct or of the elements of a collection of structs, otherwise null.
  const StructType* type() const { return type_; }
  /// Returns true for a sequence of structs that was sent without any field of its elements. Only its
  /// size() is known.
  bool has_only_size() const;

  // ---- values ----

  /// Returns the number of elements of an array or a sequence.
  Result<std::size_t> size() const;

  /// Returns the value of a number, a text or an enumeration. Texts are valid as long as the sample.
  Result<Scalar> scalar() const;

  /// Returns the value as a T. T is one of: bool or char; an integer type that can hold the integer; float or
  /// double, also for an integer that it holds exactly; std::string_view or std::string; std::span<const E>
  /// for a collection of the primitive E (std::uint8_t for booleans, and also std::byte for octets). Texts
  /// and spans refer to the sample.
  template <class T>
  Result<T> as() const;

  /// Returns the name of the value of an enumeration ("GREEN"), or the flags of a bitmask ("READ | WRITE").
  /// Empty if a part of the value has no name, or if the view is of another kind.
  std::optional<std::string> enumerator() const;

 private:
  friend Result<detail::CloudPlace> detail::cloud_place_of(const DynamicView& view,
                                                           std::span<const detail::WantedChannel> wanted);
  friend Result<detail::CellGrid> detail::find_cells(const DynamicView& message, std::string_view path,
                                                     std::size_t cell_bytes, bool (*holds)(detail::Kind));
  enum class Node : std::uint8_t { structure, collection, value };
  /// The place of the members of a struct: at slots of the index from `slot` on, or one after the other
  /// from `offset` on.
  struct Place {
    std::size_t leaf = 0;  ///< the first leaf of the struct, or of the next member
    std::size_t slot = no_slot;
    std::uint64_t offset = 0;
  };
  static constexpr std::size_t no_slot = SIZE_MAX;

  DynamicView(const detail::SampleState* s, const FieldMask* declared, const StructType::Member& member)
      : state_(s), declared_(declared), member_(&member) {}
  /// Returns true if the reader declared any of these leaves and the sample has that leaf.
  bool has_any_of(std::size_t leaf, std::size_t count) const {
    return state_->mask->any_of(leaf, count) && (declared_ == nullptr || declared_->any_of(leaf, count));
  }
  /// Returns true if the reader declared all of these leaves and the sample has them.
  bool has_all_of(std::size_t leaf, std::size_t count) const {
    return present_ && state_->mask->all_of(leaf, count) &&
           (declared_ == nullptr || declared_->all_of(leaf, count));
  }
  /// Returns false if the value in this sample differs from the published value because the sample has only
  /// some channels of a cloud.
  bool is_as_published(std::size_t leaf, std::size_t count) const {
    return state_->log == nullptr || state_->log->is_as_published(leaf, count);
  }
  /// Returns the number of the member with this name; nothing if the struct has none, or if the view is no
  /// struct.
  std::optional<std::size_t> number_of(std::string_view member) const;
  DynamicView element(std::size_t i) const;
  DynamicView member_at(const StructType::Member& m, const Place& place) const;
  DynamicView element_at(std::uint64_t offset) const;
  Place place_of(std::size_t member) const;
  void pass(const StructType::Member& m, Place& place) const;
  std::uint64_t behind_element(std::uint64_t offset) const;
  std::size_t element_leaf() const;
  DynamicView put_together() const;
  Result<std::span<const std::byte>> part() const;
  detail::Extent extent() const;
  DynamicView failed(Errc code, std::string message) const;
  DynamicView malformed() const;
  Error not_readable(const char* wanted) const;
  void note() const {
    if (state_->log != nullptr && error_ == nullptr && member_ != nullptr)
      state_->log->touch(place_.leaf, state_->mask->contains(place_.leaf) && is_as_published(place_.leaf, 1));
  }
  std::string label() const;
  Result<std::span<const std::byte>> primitives(std::size_t element_bytes, const char* wanted,
                                                bool (*matches)(detail::Kind)) const;

  const detail::SampleState* state_;
  /// The mask that the reader declared; null: all fields that the sample has.
  const FieldMask* declared_ = nullptr;
  const StructType::Member* member_ = nullptr;
  const StructType* type_ = nullptr;
  /// For a struct or a part in place, all its members are used; otherwise only leaf and offset.
  Place place_{};
  Node node_ = Node::value;
  bool present_ = true;
  bool is_in_place_ = false;  ///< true for a part of a field that is not in the body of the sample
  std::shared_ptr<const Error> error_;
};

/// The members of a struct, to iterate over once or more. The object has its own copy of the view.
class DynamicView::Members {
 public:
  class iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using difference_type = std::ptrdiff_t;
    using value_type = DynamicView;

    iterator() = default;
    iterator(const DynamicView* of, std::size_t i) : of_(of), i_(i), place_(of->place_) {}
    DynamicView operator*() const { return of_->member_at(of_->type_->members[i_], place_); }
    iterator& operator++() {
      of_->pass(of_->type_->members[i_++], place_);
      return *this;
    }
    void operator++(int) { ++*this; }
    friend bool operator==(const iterator& a, const iterator& b) { return a.i_ == b.i_; }

   private:
    const DynamicView* of_ = nullptr;
    std::size_t i_ = 0;
    Place place_;
  };

  /// Made by DynamicView::members().
  explicit Members(DynamicView of) : of_(std::move(of)) {}
  /// Returns an iterator to the first member.
  iterator begin() const { return {&of_, 0}; }
  /// Returns the iterator past the last member.
  iterator end() const {
    return {&of_, of_.is_struct() && of_.error() == nullptr ? of_.type_->members.size() : 0};
  }

 private:
  DynamicView of_;
};

/// The elements of an array or a sequence, to iterate over once or more. The object has its own copy of the
/// view.
class DynamicView::Elements {
 public:
  class iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using difference_type = std::ptrdiff_t;
    using value_type = DynamicView;

    iterator() = default;
    iterator(const DynamicView* of, std::uint64_t offset, std::size_t left)
        : of_(of), offset_(offset), left_(left) {}
    DynamicView operator*() const {
      return offset_ == detail::no_offset ? of_->malformed() : of_->element_at(offset_);
    }
    iterator& operator++() {
      const bool at_end = --left_ == 0 || offset_ == detail::no_offset;
      if (at_end) left_ = 0;
      if (!at_end) offset_ = of_->behind_element(offset_);
      return *this;
    }
    void operator++(int) { ++*this; }
    friend bool operator==(const iterator& a, const iterator& b) { return a.left_ == b.left_; }

   private:
    const DynamicView* of_ = nullptr;
    std::uint64_t offset_ = 0;
    std::size_t left_ = 0;
  };

  /// Made by DynamicView::elements().
  explicit Elements(DynamicView of);
  /// Returns an iterator to the first element.
  iterator begin() const { return {&of_, first_, left_}; }
  /// Returns the iterator past the last element.
  iterator end() const { return {&of_, 0, 0}; }

 private:
  DynamicView of_;
  std::uint64_t first_ = detail::no_offset;
  std::size_t left_ = 0;
};

inline DynamicView::Members DynamicView::members() const { return Members(*this); }
inline DynamicView::Elements DynamicView::elements() const { return Elements(*this); }

namespace detail {

template <class T>
inline constexpr bool is_span = false;
template <class E>
inline constexpr bool is_span<std::span<const E>> = true;

template <class T>
inline constexpr bool is_number =
    std::is_arithmetic_v<T> && !std::is_same_v<T, bool> && !std::is_same_v<T, char>;

/// Returns the value as a T, or nothing if a T cannot hold it.
template <class T, class V>
std::optional<T> converted(V v) {
  if constexpr (std::is_same_v<V, T> || (std::is_same_v<V, float> && std::is_same_v<T, double>)) {
    return v;
  } else if constexpr (std::is_same_v<V, std::string_view> && std::is_same_v<T, std::string>) {
    return std::string(v);
  } else if constexpr (std::is_integral_v<V> && is_number<V> && std::is_integral_v<T> && is_number<T>) {
    if (std::in_range<T>(v)) return static_cast<T>(v);
  } else if constexpr (std::is_integral_v<V> && is_number<V> && std::is_floating_point_v<T>) {
    constexpr std::int64_t exact = std::int64_t{1} << std::numeric_limits<T>::digits;
    if (std::cmp_less_equal(v, exact) && std::cmp_greater_equal(v, -exact)) return static_cast<T>(v);
  }
  return std::nullopt;
}

}  // namespace detail

template <class T>
Result<T> DynamicView::as() const {
  if constexpr (detail::is_span<T>) {
    using E = std::remove_const_t<typename T::element_type>;
    return primitives(sizeof(E), "elements of that type", detail::holds<E>).map([](auto bytes) {
      return T(reinterpret_cast<const E*>(bytes.data()), bytes.size() / sizeof(E));
    });
  } else {
    const Result<Scalar> value = scalar();
    if (!value) return tl::unexpected(value.error());
    std::optional<T> converted = std::visit([](auto v) { return detail::converted<T>(v); }, *value);
    if (!converted) return fail(Errc::type_mismatch, label() + " does not fit into what was asked for");
    return *std::move(converted);
  }
}

}  // namespace sft
