#include "sft/detail/project.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace sft::detail {

ProjectionPlan::ProjectionPlan(const StructType& type, FieldMask mask) : mask_(std::move(mask)) {
  std::size_t leaf = 0;
  std::size_t slot = 0;
  add(type, leaf, slot);
  for (Step& step : steps_) {
    if (step.member == nullptr) measure(step.run);
  }
}

void ProjectionPlan::add(const StructType& type, std::size_t& leaf, std::size_t& slot) {
  for (const Member& m : type.members) {
    if (m.kind == Kind::structure && m.shape == Shape::single) {
      add(*m.type, leaf, slot);
      continue;
    }
    if (mask_.any_of(leaf, leaf_count(m))) {
      if (is_primitive(m.kind) && m.shape != Shape::sequence) {
        add_block(m, leaf, slot);
      } else {
        steps_.push_back({.slot = slot, .leaf = leaf, .member = &m});
      }
    }
    leaf += leaf_count(m);
    ++slot;
  }
}

void ProjectionPlan::add_block(const Member& m, std::size_t leaf, std::size_t slot) {
  const bool continues_run = !steps_.empty() && steps_.back().member == nullptr && slot == next_slot_;
  if (!continues_run) {
    steps_.push_back({.slot = slot, .leaf = leaf});
    steps_.back().run.first_block = static_cast<std::uint32_t>(blocks_.size());
  }
  const auto alignment = static_cast<std::uint32_t>(size_of(m.kind));
  blocks_.push_back({std::uint64_t{m.count} * alignment, alignment});
  Run& run = steps_.back().run;
  run.blocks += 1;
  run.alignment = std::max(run.alignment, alignment);
  next_slot_ = slot + 1;
}

void ProjectionPlan::measure(Run& run) const {
  for (std::size_t begin = 0; begin < run.bytes_at.size(); ++begin) {
    std::uint64_t end = begin;
    for (std::uint32_t i = 0; i < run.blocks; ++i) {
      const Block& block = blocks_[run.first_block + i];
      end = align_up(end, block.alignment) + block.bytes;
    }
    run.bytes_at[begin] = end - begin;
  }
}

/// Copies selected members from a source position to the end of the projected body, keeping both alignments.
class Projection::Writer {
 public:
  Writer(Projection& out, const SampleState& source, const ProjectionPlan& plan)
      : out_(out), s_(source), plan_(plan), mask_(plan.mask_) {}

  bool all() {
    for (const ProjectionPlan::Step& step : plan_.steps_) {
      const std::uint32_t offset = __atomic_load_n(s_.index + step.slot, __ATOMIC_RELAXED);
      if (offset == no_offset) return false;
      from_ = offset;
      if (!(step.member == nullptr ? run(step.run) : member(*step.member, step.leaf, true))) return false;
    }
    return true;
  }

  /// Sets the pointers of the staged segments, now that the staging buffer moves no more.
  void finish() {
    close_staged();
    out_.bytes_ = to_;
    const std::byte* staged = out_.staging_.data();
    for (Segment& segment : out_.segments_) {
      if (segment.data != nullptr) continue;
      segment.data = staged;
      staged += segment.bytes;
    }
  }

 private:
  bool run(const ProjectionPlan::Run& run) {
    const ProjectionPlan::Block* block = &plan_.blocks_[run.first_block];
    from_ = align_up(from_, block->alignment);
    const std::uint64_t bytes = run.bytes_at[from_ % run.bytes_at.size()];
    if (checked_block(s_, from_, bytes, 1) == no_offset) return false;
    align(block->alignment);
    if ((from_ - to_) % run.alignment == 0) {
      copy(from_, bytes);
      return true;
    }
    for (const auto* const end = block + run.blocks; block != end; ++block) {
      align(block->alignment);
      copy(align_up(from_, block->alignment), block->bytes);
    }
    return true;
  }

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

  /// `has_slot` is true if the index finds the next member, so that the end of this one is not needed.
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
    const bool unchanged = same_selection(leaf, leaves) && (from_ - to_) % type.alignment == 0;
    if (unchanged || !mask_.any_of(leaf, leaves)) {
      const std::uint64_t first = from_;
      const std::uint32_t behind = skip_elements(s_, type, leaf, n, from_);
      if (behind == no_offset) return false;
      from_ = behind;
      if (unchanged) copy(first, from_ - first);
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
    if (mask_.all_of(leaf, leaves)) return true;  // the source has them all, too
    for (std::size_t i = leaf; i < leaf + leaves; ++i) {
      if (mask_.contains(i) != s_.mask->contains(i)) return false;
    }
    return true;
  }

  void align(std::size_t alignment) {
    static constexpr std::byte zeros[8]{};
    if (const std::uint64_t padding = align_up(to_, alignment) - to_; padding != 0) stage(zeros, padding);
  }

  void copy(std::uint64_t first, std::size_t bytes) {
    if (bytes < reference_bytes_min) {
      stage(s_.body + first, bytes);
    } else {
      close_staged();
      out_.segments_.push_back({s_.body + first, bytes});
      to_ += bytes;
    }
    from_ = first + bytes;
  }

  void stage(const void* data, std::size_t bytes) {
    if (bytes == 0) return;
    if (out_.staging_.size() - staged_ < bytes) out_.staging_.resize(2 * out_.staging_.size() + bytes);
    std::memcpy(out_.staging_.data() + staged_, data, bytes);
    staged_ += bytes;
    to_ += bytes;
  }

  /// Makes a segment of the bytes that were staged since the last one.
  void close_staged() {
    if (staged_ == closed_) return;
    out_.segments_.push_back({nullptr, staged_ - closed_});
    closed_ = staged_;
  }

  Projection& out_;
  const SampleState& s_;
  const ProjectionPlan& plan_;
  const FieldMask& mask_;
  std::uint64_t from_ = 0;  ///< position in the source
  std::uint64_t to_ = 0;    ///< position in the projected body
  std::size_t staged_ = 0;  ///< bytes in the staging buffer
  std::size_t closed_ = 0;  ///< bytes in the staging buffer that segments contain
};

void Projection::reserve(const Memory& memory) {
  segments_.clear();
  segments_.reserve(memory.segments);
  if (staging_.size() < memory.staging_bytes) staging_.resize(memory.staging_bytes);
}

bool Projection::project(const SampleState& source, const ProjectionPlan& plan) {
  segments_.clear();
  bytes_ = 0;
  if (!source.mask->contains(plan.mask())) return false;
  Writer writer(*this, source, plan);
  const bool ok = writer.all();
  writer.finish();
  return ok;
}

}  // namespace sft::detail
