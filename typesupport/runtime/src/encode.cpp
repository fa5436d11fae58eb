#include "sft/detail/encode.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <concepts>
#include <string>

#include "body_writer.h"
#include "packed.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/walk.h"

namespace sft::detail {

namespace {

static_assert(std::endian::native == std::endian::little, "primitives are copied as they are");

/// Puts the selected members of an owned struct into Out, in CDR order. With a BodyCounter, it also checks
/// values. With a BodyWriter, it writes the index, and relies on the check by an earlier count. Functions
/// take the offset where they begin and return the offset where they end.
template <class Out>
class Encoder {
 public:
  /// `index` receives one offset per slot. A BodyCounter does not use it.
  Encoder(const Out& out, const FieldMask& mask, std::span<const Reservation> reservations,
          std::uint32_t* index)
      : out_(out), mask_(mask), reservations_(reservations), index_(index) {}

  EncodeStatus status() const { return status_; }

  /// `in_slots` is true if the members have slots, because the struct is in no collection.
  std::uint64_t structure(const StructType& type, const std::byte* object, std::size_t leaf, bool in_slots,
                          std::uint64_t at) {
    for (const Member& m : type.members) {
      const std::size_t leaves = leaf_count(m);
      if (!mask_.any_of(leaf, leaves)) {
        if (in_slots) absent(slot_count(m));
      } else if (m.kind == Kind::structure && m.shape == Shape::single) {
        at = nested(*m.type, object + m.offset, leaf, in_slots, at);
      } else {
        at = out_.align(at, slot_alignment(m));
        if (in_slots) present(at);
        at = member(m, object + m.offset, leaf, in_slots, at);
      }
      leaf += leaves;
    }
    return at;
  }

 private:
  static constexpr bool is_counting = std::same_as<Out, BodyCounter>;

  void absent(std::size_t slots) {
    if constexpr (!is_counting) index_ = std::fill_n(index_, slots, no_offset);
  }
  void present(std::uint64_t at) {
    if constexpr (!is_counting) *index_++ = static_cast<std::uint32_t>(at);
  }
  void fail(EncodeStatus why) {
    if constexpr (is_counting) status_ = why;
  }

  /// Returns true if the encoding of the struct equals its bytes in memory.
  bool is_verbatim(const StructType& type, std::size_t leaf) const {
    return type.is_packed_in_memory && mask_.all_of(leaf, leaf_count(type));
  }

  std::uint64_t nested(const StructType& type, const std::byte* object, std::size_t leaf, bool in_slots,
                       std::uint64_t at) {
    if (!is_verbatim(type, leaf)) return structure(type, object, leaf, in_slots, at);
    at = out_.align(at, type.alignment);
    if constexpr (!is_counting) {
      if (in_slots) write_packed_slots(type, static_cast<std::uint32_t>(at), index_);
    }
    return out_.put(at, object, type.packed_bytes);
  }

  std::uint64_t member(const Member& m, const std::byte* value, std::size_t leaf, bool in_slots,
                       std::uint64_t at) {
    if (m.shape != Shape::sequence) return elements(m, value, m.count, leaf, at);
    const std::size_t n = m.access->size(value);
    if (in_slots && m.kind != Kind::structure) {
      if (const Reservation* r = reservation(leaf)) return reserved(m, *r->length, at);
    }
    at = length(m, n, at);
    if (status_ != EncodeStatus::ok) return at;
    if (m.access->data == nullptr) return bits(m, value, n, at);
    return elements(m, static_cast<const std::byte*>(m.access->data(value)), n,
                    m.kind == Kind::structure ? leaf + 1 : leaf, at);
  }

  const Reservation* reservation(std::size_t leaf) const {
    for (const Reservation& r : reservations_) {
      if (r.leaf == leaf && r.length) return &r;
    }
    return nullptr;
  }

  std::uint64_t length(const Member& m, std::size_t n, std::uint64_t at) {
    if (n > no_offset - 1 || (m.bound != 0 && n > m.bound)) fail(EncodeStatus::too_large);
    const auto on_wire = static_cast<std::uint32_t>(n);
    return out_.put(at, &on_wire, sizeof on_wire);
  }

  std::uint64_t reserved(const Member& m, std::uint32_t n, std::uint64_t at) {
    at = length(m, n, at);
    return n == 0 ? at : out_.align(at, size_of(m.kind)) + n * size_of(m.kind);
  }

  /// Puts the elements of a std::vector<bool>.
  std::uint64_t bits(const Member& m, const void* vector, std::size_t n, std::uint64_t at) {
    for (std::size_t i = 0; i < n; ++i) {
      const bool bit = m.access->get(vector, i);
      at = out_.put(at, &bit, 1);
    }
    return at;
  }

  std::uint64_t elements(const Member& m, const std::byte* first, std::size_t n, std::size_t leaf,
                         std::uint64_t at) {
    if (n == 0) return at;
    if (m.kind == Kind::structure) return structures(m, first, n, leaf, at);
    if (m.kind == Kind::string) {
      for (std::size_t i = 0; i < n; ++i)
        at = string(m, *reinterpret_cast<const std::string*>(first + i * m.stride), at);
      return at;
    }
    if (is_counting && m.kind == Kind::boolean) check_booleans(first, n);
    return out_.put_run(out_.align(at, size_of(m.kind)), first, n * size_of(m.kind));
  }

  std::uint64_t structures(const Member& m, const std::byte* first, std::size_t n, std::size_t leaf,
                           std::uint64_t at) {
    if (!mask_.any_of(leaf, leaf_count(*m.type))) return at;
    if (m.stride == m.type->packed_bytes && is_verbatim(*m.type, leaf))
      return out_.put(out_.align(at, m.type->alignment), first, n * m.stride);
    for (std::size_t i = 0; i < n; ++i) at = structure(*m.type, first + i * m.stride, leaf, false, at);
    return at;
  }

  std::uint64_t string(const Member& m, const std::string& text, std::uint64_t at) {
    if (is_counting) check(m, text);
    const auto with_nul = static_cast<std::uint32_t>(text.size() + 1);
    at = out_.put(out_.align(at, 4), &with_nul, sizeof with_nul);
    return out_.put(at, text.c_str(), with_nul);
  }

  void check(const Member& m, const std::string& text) {
    if (text.size() >= no_offset - 1 || (m.string_bound != 0 && text.size() > m.string_bound)) {
      fail(EncodeStatus::too_large);
    } else if (text.find('\0') != std::string::npos) {
      fail(EncodeStatus::string_has_nul);
    }
  }

  /// Checks a collection of booleans, which are bytes in memory. Receivers refuse values other than 0 and
  /// 1.
  void check_booleans(const std::byte* first, std::size_t n) {
    const auto is_none = [](std::byte b) { return b > std::byte{1}; };
    if (std::any_of(first, first + n, is_none)) fail(EncodeStatus::bad_boolean);
  }

  const Out out_;
  const FieldMask& mask_;
  const std::span<const Reservation> reservations_;
  std::uint32_t* index_;
  EncodeStatus status_ = EncodeStatus::ok;
};

}  // namespace

EncodedSize encoded_size(const StructType& type, const void* value, const FieldMask& mask,
                         std::span<const Reservation> reservations) noexcept {
  Encoder encoder(BodyCounter(), mask, reservations, nullptr);
  const std::uint64_t bytes = encoder.structure(type, static_cast<const std::byte*>(value), 0, true, 0);
  if (encoder.status() != EncodeStatus::ok) return {encoder.status(), 0};
  if (bytes >= no_offset) return {EncodeStatus::too_large, 0};
  return {EncodeStatus::ok, static_cast<std::uint32_t>(bytes)};
}

void encode(const StructType& type, const void* value, const FieldMask& mask, std::span<std::byte> body,
            std::span<std::uint32_t> index, std::span<const Reservation> reservations,
            PostponedCopies* postponed) noexcept {
  Encoder encoder(BodyWriter(body, postponed), mask, reservations, index.data());
  [[maybe_unused]] const std::uint64_t bytes =
      encoder.structure(type, static_cast<const std::byte*>(value), 0, true, 0);
  assert(bytes == body.size());
}

const char* to_string(EncodeStatus status) {
  switch (status) {
    case EncodeStatus::ok:
      return "ok";
    case EncodeStatus::too_large:
      return "a sequence or string exceeds its bound, or the sample 4 GiB";
    case EncodeStatus::bad_boolean:
      return "a boolean is neither 0 nor 1";
    case EncodeStatus::string_has_nul:
      return "a string contains a NUL character";
  }
  return "unknown";
}

}  // namespace sft::detail
