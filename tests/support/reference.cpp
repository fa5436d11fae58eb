#include "tests/support/reference.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace sft::test::reference {

namespace {

using namespace detail;

std::size_t leaves(const Member& m) {
  if (m.kind != Kind::structure) return 1;
  return (m.shape == Shape::sequence ? 1 : 0) + reference::leaves(*m.type);
}

bool has_any(const FieldMask& mask, std::size_t leaf, std::size_t count) {
  for (std::size_t i = leaf; i < leaf + count; ++i) {
    if (mask.contains(i)) return true;
  }
  return false;
}

/// Calls visit(member, number of the member's first leaf) for each member of a struct. The first leaf of the
/// struct is `leaf`.
template <class Visit>
void for_each_member(const StructType& type, std::size_t leaf, Visit visit) {
  for (const Member& m : type.members) {
    visit(m, leaf);
    leaf += leaves(m);
  }
}

void add_lengths(const StructType& type, std::size_t first_leaf, FieldMask& mask) {
  for_each_member(type, first_leaf, [&](const Member& m, std::size_t leaf) {
    if (m.kind != Kind::structure) return;
    const bool is_sequence = m.shape == Shape::sequence;
    if (is_sequence && has_any(mask, leaf, leaves(m))) mask.insert(leaf);
    add_lengths(*m.type, leaf + (is_sequence ? 1 : 0), mask);
  });
}

void add_keys(const StructType& type, FieldMask& mask) {
  for_each_member(type, 0, [&](const Member& m, std::size_t leaf) {
    for (std::size_t i = 0; m.key && i < leaves(m); ++i) mask.insert(leaf + i);
  });
}

class Copier {
 public:
  explicit Copier(const FieldMask& mask) : mask_(mask) {}

  void structure(const StructType& type, std::size_t first_leaf, const std::byte* from, std::byte* to) const {
    for_each_member(type, first_leaf, [&](const Member& m, std::size_t leaf) {
      if (m.kind != Kind::structure || m.shape == Shape::sequence) {
        if (!mask_.contains(leaf)) return;
      }
      const Elements source = elements_of(m, from);
      std::byte* target = resized(m, to, source.count);
      for (std::size_t i = 0; i < source.count; ++i) {
        element(m, leaf, source.first + i * m.stride, target + i * m.stride);
      }
    });
  }

 private:
  void element(const Member& m, std::size_t leaf, const std::byte* from, std::byte* to) const {
    if (m.kind == Kind::structure) {
      structure(*m.type, leaf + (m.shape == Shape::sequence ? 1 : 0), from, to);
    } else if (m.kind == Kind::string) {
      *reinterpret_cast<std::string*>(to) = *reinterpret_cast<const std::string*>(from);
    } else {
      std::copy(from, from + size_of(m.kind), to);
    }
  }

  const FieldMask& mask_;
};

class Writer {
 public:
  explicit Writer(const FieldMask& mask) : mask_(mask) {}

  void structure(const StructType& type, std::size_t first_leaf, const std::byte* object) {
    for_each_member(type, first_leaf, [&](const Member& m, std::size_t leaf) {
      if (!has_any(mask_, leaf, leaves(m))) return;
      const Elements values = elements_of(m, object);
      if (m.shape == Shape::sequence) number(values.count);
      for (std::size_t i = 0; i < values.count; ++i) element(m, leaf, values.first + i * m.stride);
    });
  }

  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void element(const Member& m, std::size_t leaf, const std::byte* value) {
    if (m.kind == Kind::structure) {
      structure(*m.type, leaf + (m.shape == Shape::sequence ? 1 : 0), value);
    } else if (m.kind == Kind::string) {
      const auto& text = *reinterpret_cast<const std::string*>(value);
      number(text.size() + 1);
      put(reinterpret_cast<const std::byte*>(text.c_str()), text.size() + 1);
    } else {
      align(size_of(m.kind));
      put(value, size_of(m.kind));
    }
  }

  void number(std::size_t n) {
    align(4);
    for (int shift = 0; shift < 32; shift += 8) bytes_.push_back(static_cast<std::byte>(n >> shift));
  }
  void put(const std::byte* first, std::size_t count) { bytes_.insert(bytes_.end(), first, first + count); }
  void align(std::size_t alignment) {
    while (bytes_.size() % alignment != 0) bytes_.push_back(std::byte{0});
  }

  const FieldMask& mask_;
  std::vector<std::byte> bytes_;
};

/// Compares given bytes with the CDR of a value instead of writing the CDR.
class Comparer {
 public:
  Comparer(const FieldMask& mask, std::span<const std::byte> bytes) : mask_(mask), bytes_(bytes) {}

  bool structure(const StructType& type, std::size_t first_leaf, const std::byte* object) {
    bool same = true;
    for_each_member(type, first_leaf, [&](const Member& m, std::size_t leaf) {
      if (!has_any(mask_, leaf, leaves(m))) return;
      const Elements values = elements_of(m, object);
      if (m.shape == Shape::sequence) same = same && number() == values.count;
      for (std::size_t i = 0; same && i < values.count; ++i)
        same = element(m, leaf, values.first + i * m.stride);
    });
    return same;
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  bool element(const Member& m, std::size_t leaf, const std::byte* value) {
    if (m.kind == Kind::structure)
      return structure(*m.type, leaf + (m.shape == Shape::sequence ? 1 : 0), value);
    if (m.kind != Kind::string) {
      align(size_of(m.kind));
      return same(value, size_of(m.kind));
    }
    const auto& text = *reinterpret_cast<const std::string*>(value);
    const std::optional<std::size_t> with_nul = number();
    if (text.empty() && with_nul == 0U) return true;
    return with_nul == text.size() + 1 &&
           same(reinterpret_cast<const std::byte*>(text.c_str()), text.size() + 1);
  }

  std::optional<std::size_t> number() {
    align(4);
    if (at_ + 4 > bytes_.size()) return std::nullopt;
    std::size_t n = 0;
    for (int shift = 0; shift < 32; shift += 8) n |= std::to_integer<std::size_t>(bytes_[at_++]) << shift;
    return n;
  }
  bool same(const std::byte* first, std::size_t count) {
    if (at_ + count > bytes_.size()) return false;
    at_ += count;
    return std::equal(first, first + count, bytes_.begin() + static_cast<std::ptrdiff_t>(at_ - count));
  }
  void align(std::size_t alignment) {
    while (at_ % alignment != 0) ++at_;
  }

  const FieldMask& mask_;
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

}  // namespace

std::size_t leaves(const StructType& type) {
  std::size_t count = 0;
  for (const Member& m : type.members) count += leaves(m);
  return count;
}

FieldMask closed(const StructType& type, FieldMask mask) {
  add_keys(type, mask);
  add_lengths(type, 0, mask);
  return mask;
}

void project(const OwnedValue& from, const FieldMask& mask, OwnedValue& to) {
  const auto* source = static_cast<const std::byte*>(from.get());
  Copier(mask).structure(from.type(), 0, source, static_cast<std::byte*>(to.get()));
}

std::vector<std::byte> cdr(const OwnedValue& value, const FieldMask& mask) {
  Writer writer(mask);
  writer.structure(value.type(), 0, static_cast<const std::byte*>(value.get()));
  return writer.take();
}

bool is_cdr_of(std::span<const std::byte> bytes, const OwnedValue& value, const FieldMask& mask) {
  Comparer comparer(mask, bytes);
  return comparer.structure(value.type(), 0, static_cast<const std::byte*>(value.get())) && comparer.at_end();
}

}  // namespace sft::test::reference
