#include "sft/detail/decode.h"

#include <string>

namespace sft::detail {

namespace {

class Decoder {
 public:
  explicit Decoder(const SampleState& s, std::uint64_t begin = 0) : s_(s), at_(begin) {}

  WalkStatus structure(const StructType& type, std::byte* object, std::size_t leaf) {
    for (const Member& m : type.members) {
      if (const WalkStatus status = member(m, object + m.offset, leaf); status != WalkStatus::ok)
        return status;
      leaf += leaf_count(m);
    }
    return WalkStatus::ok;
  }

 private:
  WalkStatus member(const Member& m, std::byte* value, std::size_t leaf) {
    if (!s_.mask->any_of(leaf, leaf_count(m))) return WalkStatus::ok;
    if (m.kind == Kind::structure && m.shape == Shape::single) {
      return is_verbatim(*m.type, leaf) ? block(value, 1, m.type->packed_bytes, m.type->alignment)
                                        : structure(*m.type, value, leaf);
    }
    if (m.shape != Shape::sequence) return elements(m, value, m.count, leaf);
    const Extent length = checked_length(s_, at_);
    if (!length) return WalkStatus::truncated;
    if (m.bound != 0 && length.count > m.bound) return WalkStatus::bad_length;
    at_ = length.first;
    const std::size_t element_leaf = m.kind == Kind::structure ? leaf + 1 : leaf;
    if (length.count > most_elements(m, element_leaf)) return WalkStatus::bad_length;
    auto* first = static_cast<std::byte*>(m.access->resize(value, length.count));
    if (m.access->data == nullptr) return bits(m, value, length.count);
    return elements(m, first, length.count, element_leaf);
  }

  /// Returns the maximum number of elements that the remaining bytes can hold.
  std::uint64_t most_elements(const Member& m, std::size_t leaf) const {
    const std::uint64_t each = m.kind == Kind::structure ? least_bytes(*m.type, leaf) : size_of(m.kind);
    return each == 0 ? max_empty_elements : (s_.body_bytes - at_) / each;
  }

  /// Returns the minimum size of a struct's selected members: without padding, with empty sequences and
  /// strings.
  std::uint64_t least_bytes(const StructType& type, std::size_t leaf) const {
    std::uint64_t bytes = 0;
    for (const Member& m : type.members) {
      if (s_.mask->any_of(leaf, leaf_count(m))) {
        const bool is_struct = m.kind == Kind::structure;
        bytes += m.shape == Shape::sequence
                     ? 4
                     : m.count * (is_struct ? least_bytes(*m.type, leaf) : size_of(m.kind));
      }
      leaf += leaf_count(m);
    }
    return bytes;
  }

  WalkStatus elements(const Member& m, std::byte* first, std::size_t n, std::size_t leaf) {
    if (m.kind == Kind::structure) return structures(m, first, n, leaf);
    if (m.kind == Kind::string) return strings(m, first, n);
    const WalkStatus status = block(first, n, size_of(m.kind), size_of(m.kind));
    if (status == WalkStatus::ok && m.kind == Kind::boolean && !all_booleans(first, n))
      return WalkStatus::bad_boolean;
    return status;
  }

  /// Returns true if the encoding of the struct equals its bytes in memory.
  bool is_verbatim(const StructType& type, std::size_t leaf) const {
    return type.is_packed_in_memory && s_.mask->all_of(leaf, leaf_count(type));
  }

  WalkStatus structures(const Member& m, std::byte* first, std::size_t n, std::size_t leaf) {
    if (!s_.mask->any_of(leaf, leaf_count(*m.type))) return WalkStatus::ok;
    if (m.stride == m.type->packed_bytes && is_verbatim(*m.type, leaf))
      return block(first, n, m.stride, m.type->alignment);
    for (std::size_t i = 0; i < n; ++i) {
      const WalkStatus status = structure(*m.type, first + i * m.stride, leaf);
      if (status != WalkStatus::ok) return status;
    }
    return WalkStatus::ok;
  }

  WalkStatus block(std::byte* to, std::size_t n, std::size_t element_bytes, std::size_t alignment) {
    const std::uint32_t at = checked_block(s_, at_, n, element_bytes, alignment);
    if (at == no_offset) return WalkStatus::truncated;
    if (n != 0) std::memcpy(to, s_.body + at, n * element_bytes);
    at_ = at + n * element_bytes;
    return WalkStatus::ok;
  }

  /// Reads the elements of a std::vector<bool>.
  WalkStatus bits(const Member& m, void* vector, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      std::byte b{};
      if (const WalkStatus status = block(&b, 1, 1, 1); status != WalkStatus::ok) return status;
      if (b > std::byte{1}) return WalkStatus::bad_boolean;
      m.access->set(vector, i, b == std::byte{1});
    }
    return WalkStatus::ok;
  }

  /// Returns true if all bytes are booleans, and replaces invalid booleans. Checks the copy, since the
  /// original in shared memory may change.
  static bool all_booleans(std::byte* first, std::size_t n) {
    bool all = true;
    for (std::byte* b = first; b != first + n; ++b) {
      all &= *b <= std::byte{1};
      *b &= std::byte{1};
    }
    return all;
  }

  WalkStatus strings(const Member& m, std::byte* first, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      const Extent length = checked_length(s_, at_);
      if (!length || checked_block(s_, length.first, length.count, 1) == no_offset)
        return WalkStatus::truncated;
      const std::size_t characters = length.count == 0 ? 0 : length.count - 1;
      reinterpret_cast<std::string*>(first + i * m.stride)
          ->assign(reinterpret_cast<const char*>(s_.body + length.first), characters);
      at_ = std::uint64_t{length.first} + length.count;
    }
    return WalkStatus::ok;
  }

  const SampleState& s_;
  std::uint64_t at_;
};

}  // namespace

WalkStatus decode(const SampleState& s, const StructType& type, void* value) {
  return Decoder(s).structure(type, static_cast<std::byte*>(value), 0);
}

WalkStatus decode_struct(const SampleState& s, const StructType& type, StructPlace place, void* value) {
  if (place.offset >= s.body_bytes) return WalkStatus::truncated;
  return Decoder(s, place.offset).structure(type, static_cast<std::byte*>(value), place.leaf);
}

}  // namespace sft::detail
