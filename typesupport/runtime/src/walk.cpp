#include "sft/detail/walk.h"

#include <algorithm>

#include "packed.h"

namespace sft::detail {

namespace {

/// Walks over a body once. If Check is true, it validates the contents. Otherwise it only finds the ends of
/// members.
template <bool Check>
class Walker {
 public:
  explicit Walker(const SampleState& s, std::uint64_t offset) : s_(s), at_(offset) {}

  WalkStatus status() const { return status_; }
  std::uint32_t at() const { return status_ == WalkStatus::ok ? static_cast<std::uint32_t>(at_) : no_offset; }

  bool structure(const StructType& type, std::size_t leaf) {
    if (!type.first_leaves.empty()) return selected_members(type, leaf);
    for (const Member& m : type.members) {
      if (!member(m, leaf)) return false;
      leaf += leaf_count(m);
    }
    return true;
  }

  /// Walks over a struct, and writes the offset of every slot to `index`, which it advances.
  bool indexed_structure(const StructType& type, std::size_t leaf, std::uint32_t*& index) {
    for (const Member& m : type.members) {
      if (m.kind == Kind::structure && m.shape == Shape::single) {
        if (!nested(*m.type, leaf, index)) return false;
      } else {
        const bool present = s_.mask->any_of(leaf, leaf_count(m));
        *index++ = present ? static_cast<std::uint32_t>(align_up(at_, slot_alignment(m))) : no_offset;
        if (present && !member(m, leaf)) return false;
      }
      leaf += leaf_count(m);
    }
    return true;
  }

  bool member(const Member& m, std::size_t leaf) {
    if (m.kind != Kind::structure) return !s_.mask->contains(leaf) || leaf_member(m);
    if (m.shape == Shape::single)
      return is_packed(*m.type, leaf) ? packed(*m.type, 1) : structure(*m.type, leaf);
    if (!s_.mask->any_of(leaf, leaf_count(m))) return true;
    std::uint32_t elements = m.count;
    if (m.shape == Shape::sequence) {
      if (!length(m, elements)) return false;
      ++leaf;
    }
    return this->elements(*m.type, leaf, elements);
  }

  bool elements(const StructType& type, std::size_t leaf, std::uint32_t n) {
    if (is_packed(type, leaf)) return packed(type, n);
    // If no leaf is selected, the elements take no bytes.
    if (!s_.mask->any_of(leaf, leaf_count(type))) return true;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint64_t before = at_;
      if (!structure(type, leaf)) return false;
      if (at_ == before) break;  // the loop ends, because these elements take no bytes, nor do the rest
    }
    return true;
  }

 private:
  bool fail(WalkStatus why) {
    status_ = why;
    return false;
  }

  bool selected_members(const StructType& type, std::size_t first_leaf) {
    const std::size_t end = first_leaf + leaf_count(type);
    auto behind = type.first_leaves.begin();  // the search for the next member begins at `behind`
    for (std::size_t leaf = s_.mask->next(first_leaf, end); leaf < end; leaf = s_.mask->next(leaf, end)) {
      if (*behind != leaf - first_leaf)  // the next selected member is not adjacent
        behind = std::upper_bound(behind, type.first_leaves.end(), leaf - first_leaf) - 1;
      const Member& m = type.members[static_cast<std::size_t>(behind - type.first_leaves.begin())];
      const std::size_t member_leaf = first_leaf + *behind++;
      if (!member(m, member_leaf)) return false;
      leaf = member_leaf + leaf_count(m);
    }
    return true;
  }

  bool nested(const StructType& type, std::size_t leaf, std::uint32_t*& index) {
    if (!is_packed(type, leaf)) return indexed_structure(type, leaf, index);
    write_packed_slots(type, static_cast<std::uint32_t>(align_up(at_, type.alignment)), index);
    return packed(type, 1);
  }

  bool is_packed(const StructType& type, std::size_t leaf) const {
    return type.packed_bytes != 0 && s_.mask->all_of(leaf, leaf_count(type));
  }

  bool packed(const StructType& type, std::uint32_t n) {
    const std::uint32_t first = checked_block(s_, at_, n, type.packed_bytes, type.alignment);
    if (first == no_offset) return fail(WalkStatus::truncated);
    at_ = first + std::uint64_t{n} * type.packed_bytes;
    return true;
  }

  bool length(const Member& m, std::uint32_t& n) {
    const Extent extent = checked_length(s_, at_);
    if (!extent) return fail(WalkStatus::truncated);
    if (Check && m.bound != 0 && extent.count > m.bound) return fail(WalkStatus::bad_length);
    at_ = extent.first;
    n = extent.count;
    return true;
  }

  bool leaf_member(const Member& m) {
    std::uint32_t n = m.count;
    if (m.shape == Shape::sequence && !length(m, n)) return false;
    return m.kind == Kind::string ? strings(m, n) : block(m.kind, n);
  }

  bool block(Kind kind, std::uint32_t n) {
    const std::uint32_t first = checked_block(s_, at_, n, size_of(kind));
    if (first == no_offset) return fail(WalkStatus::truncated);
    if (Check && kind == Kind::boolean && !all_booleans(first, n)) return fail(WalkStatus::bad_boolean);
    at_ = first + std::uint64_t{n} * size_of(kind);
    return true;
  }

  bool all_booleans(std::uint32_t first, std::uint32_t n) const {
    return std::all_of(s_.body + first, s_.body + first + n, [](std::byte b) { return b <= std::byte{1}; });
  }

  bool strings(const Member& m, std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const Extent length = checked_length(s_, at_);
      if (!length || checked_block(s_, length.first, length.count, 1) == no_offset)
        return fail(WalkStatus::truncated);
      if (Check && length.count != 0 && !text_ok(m, length)) return false;
      at_ = std::uint64_t{length.first} + length.count;
    }
    return true;
  }

  bool text_ok(const Member& m, Extent with_nul) {
    if (m.string_bound != 0 && with_nul.count - 1 > m.string_bound) return fail(WalkStatus::bad_length);
    const void* nul = std::memchr(s_.body + with_nul.first, 0, with_nul.count);
    return nul == s_.body + with_nul.first + with_nul.count - 1 || fail(WalkStatus::bad_string);
  }

  const SampleState& s_;
  std::uint64_t at_;
  WalkStatus status_ = WalkStatus::ok;
};

}  // namespace

std::uint32_t skip(const SampleState& s, const Member& member, std::size_t leaf,
                   std::uint64_t offset) noexcept {
  Walker<false> walker(s, offset);
  walker.member(member, leaf);
  return walker.at();
}

std::uint32_t skip(const SampleState& s, const StructType& type, std::size_t leaf,
                   std::uint64_t offset) noexcept {
  Walker<false> walker(s, offset);
  walker.structure(type, leaf);
  return walker.at();
}

std::uint32_t skip_elements(const SampleState& s, const StructType& type, std::size_t leaf, std::uint32_t n,
                            std::uint64_t offset) noexcept {
  Walker<false> walker(s, offset);
  walker.elements(type, leaf, n);
  return walker.at();
}

std::uint32_t member_begin(const SampleState& s, const StructType& type, std::size_t member, std::size_t leaf,
                           std::uint64_t offset) noexcept {
  Walker<false> walker(s, offset);
  for (std::size_t i = 0; i < member; ++i) {
    if (!walker.member(type.members[i], leaf)) break;
    leaf += leaf_count(type.members[i]);
  }
  return walker.at();
}

WalkStatus build_index(const SampleState& s, const StructType& type, std::span<std::uint32_t> index,
                       std::uint32_t* body_end) noexcept {
  Walker<true> walker(s, 0);
  std::uint32_t* slot = index.data();
  if (!walker.indexed_structure(type, 0, slot)) return walker.status();
  if (s.body_bytes - walker.at() > max_trailing_bytes) return WalkStatus::trailing_bytes;
  if (body_end != nullptr) *body_end = walker.at();
  return WalkStatus::ok;
}

const char* to_string(WalkStatus status) {
  switch (status) {
    case WalkStatus::ok:
      return "ok";
    case WalkStatus::truncated:
      return "the bytes end inside a member";
    case WalkStatus::bad_length:
      return "a length exceeds its bound";
    case WalkStatus::bad_boolean:
      return "a boolean is neither 0 nor 1";
    case WalkStatus::bad_string:
      return "a string does not end at its first NUL";
    case WalkStatus::trailing_bytes:
      return "bytes are left over behind the last member";
    case WalkStatus::bad_delimiter:
      return "a collection does not end where its delimiter says";
    case WalkStatus::too_large:
      return "the body would have 4 GiB or more";
  }
  return "unknown";
}

bool note_leaves(const SampleState& s, std::size_t first, std::size_t count) {
  bool has_each = true;
  for (std::size_t leaf = first; leaf < first + count; ++leaf) {
    const bool present = s.mask->contains(leaf) && (s.log == nullptr || s.log->is_as_published(leaf, 1));
    if (s.log != nullptr) s.log->touch(leaf, present);
    has_each = has_each && present;
  }
  return has_each;
}

}  // namespace sft::detail
