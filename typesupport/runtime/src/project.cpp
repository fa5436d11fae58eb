#include "sft/typesupport/project.h"

#include <algorithm>

namespace sft {

namespace {

/// Largest alignment of any primitive below.
std::size_t largest_alignment(const StructType& type) {
  std::size_t largest = 1;
  for (const Member& m : type.members) {
    const std::size_t own = m.kind == Kind::structure ? largest_alignment(*m.type) : size_of(m.kind);
    largest = std::max({largest, own, m.shape == Shape::sequence ? std::size_t{4} : std::size_t{1}});
  }
  return largest;
}

}  // namespace

/// Copies selected members from a source position to the end of the projected body, keeping both alignments.
class Projection::Writer {
 public:
  Writer(Projection& out, const SampleState& source, const FieldMask& mask)
      : out_(out), s_(source), mask_(mask) {}

  bool slots(const StructType& type, std::size_t leaf, const std::uint32_t*& slot) {
    for (const Member& m : type.members) {
      if (m.kind == Kind::structure && m.shape == Shape::single) {
        if (!slots(*m.type, leaf, slot)) return false;
      } else {
        if (mask_.any_of(leaf, leaf_count(m))) {
          const std::uint32_t offset = __atomic_load_n(slot, __ATOMIC_RELAXED);
          if (offset == no_offset) return false;
          from_ = offset;
          if (!member(m, leaf, true)) return false;
        }
        ++slot;
      }
      leaf += leaf_count(m);
    }
    return true;
  }

  /// Points the staged segments into the staging buffer, which does not move any more.
  void finish() {
    const std::byte* staged = out_.staging_.data();
    for (Segment& segment : out_.segments_) {
      if (segment.data != nullptr) continue;
      segment.data = staged;
      staged += segment.bytes;
    }
  }

 private:
  bool structure(const StructType& type, std::size_t leaf) {
    for (const Member& m : type.members) {
      if (mask_.any_of(leaf, leaf_count(m))) {
        if (!member(m, leaf, false)) return false;
      } else {
        const std::uint32_t behind = skip(s_, m, leaf, from_);
        if (behind == no_offset) return false;
        from_ = behind;
      }
      leaf += leaf_count(m);
    }
    return true;
  }

  /// `has_slot`: what follows is found by the index, not behind this.
  bool member(const Member& m, std::size_t leaf, bool has_slot) {
    if (m.kind == Kind::structure && m.shape == Shape::single) return structure(*m.type, leaf);
    std::uint32_t n = m.count;
    if (m.shape == Shape::sequence && !length(n)) return false;
    if (m.kind == Kind::structure) {
      const std::size_t element_leaf = m.shape == Shape::sequence ? leaf + 1 : leaf;
      const bool only_length = !mask_.any_of(element_leaf, leaf_count(*m.type));
      return (only_length && has_slot) || elements(*m.type, element_leaf, n);
    }
    return m.kind == Kind::string ? strings(n) : block(n, size_of(m.kind));
  }

  bool length(std::uint32_t& n) {
    const Extent extent = checked_length(s_, from_);
    if (!extent) return false;
    align(4);
    stage(&extent.count, sizeof extent.count);
    from_ = extent.first;
    n = extent.count;
    return true;
  }

  bool block(std::uint32_t n, std::size_t element_bytes) {
    if (n == 0) return true;
    const std::uint32_t first = checked_block(s_, from_, n, element_bytes);
    if (first == no_offset) return false;
    align(element_bytes);
    copy(first, std::size_t{n} * element_bytes);
    return true;
  }

  bool strings(std::uint32_t n) {
    for (std::uint32_t i = 0; i < n; ++i) {
      std::uint32_t with_nul = 0;
      if (!length(with_nul) || !block(with_nul, 1)) return false;
    }
    return true;
  }

  bool elements(const StructType& type, std::size_t leaf, std::uint32_t n) {
    const std::size_t leaves = leaf_count(type);
    if (!mask_.any_of(leaf, leaves)) return skip_elements(type, leaf, n);
    if (same_selection(leaf, leaves) && (from_ - out_.bytes_) % largest_alignment(type) == 0) {
      const std::uint64_t first = from_;
      if (!skip_elements(type, leaf, n)) return false;
      copy(static_cast<std::uint32_t>(first), from_ - first);
      return true;
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint64_t before = from_;
      if (!structure(type, leaf)) return false;
      if (from_ == before) break;  // elements without bytes
    }
    return true;
  }

  bool same_selection(std::size_t leaf, std::size_t leaves) const {
    for (std::size_t i = leaf; i < leaf + leaves; ++i) {
      if (mask_.contains(i) != s_.mask->contains(i)) return false;
    }
    return true;
  }

  bool skip_elements(const StructType& type, std::size_t leaf, std::uint32_t n) {
    if (!s_.mask->any_of(leaf, leaf_count(type))) return true;  // they have no bytes, however many there are
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t behind = skip(s_, type, leaf, from_);
      if (behind == no_offset) return false;
      if (behind == from_) break;
      from_ = behind;
    }
    return true;
  }

  void align(std::size_t alignment) {
    static constexpr std::byte zeros[8]{};
    stage(zeros, align_up(out_.bytes_, alignment) - out_.bytes_);
  }

  void copy(std::uint32_t first, std::size_t bytes) {
    if (bytes < reference_bytes_min) {
      stage(s_.body + first, bytes);
    } else {
      out_.segments_.push_back({s_.body + first, bytes});
      out_.bytes_ += bytes;
    }
    from_ = first + bytes;
  }

  void stage(const void* data, std::size_t bytes) {
    if (bytes == 0) return;
    if (out_.segments_.empty() || out_.segments_.back().data != nullptr) out_.segments_.push_back({});
    const auto* first = static_cast<const std::byte*>(data);
    out_.staging_.insert(out_.staging_.end(), first, first + bytes);
    out_.segments_.back().bytes += bytes;
    out_.bytes_ += bytes;
  }

  Projection& out_;
  const SampleState& s_;
  const FieldMask& mask_;
  std::uint64_t from_ = 0;
};

bool Projection::project(const SampleState& source, const StructType& type, const FieldMask& mask) {
  staging_.clear();
  segments_.clear();
  bytes_ = 0;
  Writer writer(*this, source, mask);
  const std::uint32_t* slot = source.index;
  const bool ok = writer.slots(type, 0, slot);
  writer.finish();
  return ok;
}

}  // namespace sft
