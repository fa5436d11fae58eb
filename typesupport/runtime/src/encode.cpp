#include "sft/typesupport/encode.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <string>

#include "body_writer.h"
#include "sft/typesupport/sample_format.h"
#include "sft/typesupport/walk.h"

namespace sft {

namespace {

static_assert(std::endian::native == std::endian::little, "primitives are copied as they are");

/// Visits the selected members of an owned struct in CDR order and hands them to Out (BodyCounter or
/// BodyWriter).
template <class Out>
class Encoder {
 public:
  /// `index`, unless null, receives an offset per slot.
  Encoder(Out& out, const FieldMask& mask, std::span<const Reservation> reservations, std::uint32_t* index)
      : out_(out), mask_(mask), reservations_(reservations), index_(index) {}

  EncodeStatus status() const { return status_; }

  /// `in_slots`: its members have slots of their own, that is, no collection is around it.
  void structure(const StructType& type, const std::byte* object, std::size_t leaf, bool in_slots) {
    for (const Member& m : type.members) {
      const std::byte* value = object + m.offset;
      if (m.kind == Kind::structure && m.shape == Shape::single) {
        structure(*m.type, value, leaf, in_slots);
      } else {
        const bool present = mask_.any_of(leaf, leaf_count(m));
        if (present) align(m);
        if (in_slots && index_ != nullptr)
          *index_++ = present ? static_cast<std::uint32_t>(out_.at()) : no_offset;
        if (present) member(m, value, leaf, in_slots);
      }
      leaf += leaf_count(m);
    }
  }

 private:
  void align(const Member& m) {
    if (m.shape == Shape::sequence) {
      out_.align(4);
    } else if (m.kind != Kind::structure) {
      out_.align(size_of(m.kind));
    }
  }

  void member(const Member& m, const std::byte* value, std::size_t leaf, bool in_slots) {
    if (m.shape != Shape::sequence) return elements(m, value, m.count, leaf);
    const std::size_t n = m.access->size(value);
    if (in_slots && m.kind != Kind::structure) {
      if (const Reservation* r = reservation(leaf)) return reserved(m, *r->length);
    }
    length(m, n);
    if (status_ != EncodeStatus::ok) return;
    elements(m, static_cast<const std::byte*>(m.access->data(value)), n,
             m.kind == Kind::structure ? leaf + 1 : leaf);
  }

  const Reservation* reservation(std::size_t leaf) const {
    for (const Reservation& r : reservations_) {
      if (r.leaf == leaf && r.length) return &r;
    }
    return nullptr;
  }

  void length(const Member& m, std::size_t n) {
    if (n > no_offset - 1 || (m.bound != 0 && n > m.bound)) status_ = EncodeStatus::too_large;
    const auto on_wire = static_cast<std::uint32_t>(n);
    out_.put(&on_wire, sizeof on_wire);
  }

  void reserved(const Member& m, std::uint32_t n) {
    length(m, n);
    if (n != 0) out_.align(size_of(m.kind));
    out_.leave(n * size_of(m.kind));
  }

  void elements(const Member& m, const std::byte* first, std::size_t n, std::size_t leaf) {
    if (m.kind == Kind::structure) {
      if (!mask_.any_of(leaf, leaf_count(*m.type))) return;
      for (std::size_t i = 0; i < n; ++i) structure(*m.type, first + i * m.stride, leaf, false);
    } else if (m.kind == Kind::string) {
      for (std::size_t i = 0; i < n; ++i)
        string(m, *reinterpret_cast<const std::string*>(first + i * m.stride));
    } else if (n != 0) {
      // Collections of booleans are held as bytes; receivers refuse what is neither 0 nor 1.
      const auto no_boolean = [](std::byte b) { return b > std::byte{1}; };
      if (m.kind == Kind::boolean && std::any_of(first, first + n, no_boolean))
        status_ = EncodeStatus::bad_boolean;
      out_.align(size_of(m.kind));
      out_.put(first, n * size_of(m.kind));
    }
  }

  void string(const Member& m, const std::string& text) {
    if (text.size() >= no_offset - 1 || (m.string_bound != 0 && text.size() > m.string_bound)) {
      status_ = EncodeStatus::too_large;
    } else if (text.find('\0') != std::string::npos) {
      status_ = EncodeStatus::string_has_nul;
    }
    const auto with_nul = static_cast<std::uint32_t>(text.size() + 1);
    out_.align(4);
    out_.put(&with_nul, sizeof with_nul);
    out_.put(text.c_str(), with_nul);
  }

  Out& out_;
  const FieldMask& mask_;
  std::span<const Reservation> reservations_;
  std::uint32_t* index_;
  EncodeStatus status_ = EncodeStatus::ok;
};

}  // namespace

EncodedSize encoded_size(const StructType& type, const void* value, const FieldMask& mask,
                         std::span<const Reservation> reservations) noexcept {
  BodyCounter counter;
  Encoder encoder(counter, mask, reservations, nullptr);
  encoder.structure(type, static_cast<const std::byte*>(value), 0, true);
  if (encoder.status() != EncodeStatus::ok) return {encoder.status(), 0};
  if (counter.at() >= no_offset) return {EncodeStatus::too_large, 0};
  return {EncodeStatus::ok, static_cast<std::uint32_t>(counter.at())};
}

void encode(const StructType& type, const void* value, const FieldMask& mask, std::span<std::byte> body,
            std::span<std::uint32_t> index, std::span<const Reservation> reservations) noexcept {
  BodyWriter writer(body);
  Encoder encoder(writer, mask, reservations, index.data());
  encoder.structure(type, static_cast<const std::byte*>(value), 0, true);
  assert(encoder.status() == EncodeStatus::ok && writer.at() == body.size());
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

}  // namespace sft
