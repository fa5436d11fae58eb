#include "sft/detail/project.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "gather.h"
#include "sft/detail/postponed_copies.h"

namespace sft::detail {

namespace {

/// Returns true if a part changes the field with this role. The list of channels changes only if channels
/// were requested.
bool is_rewritten(LayoutRole role, const Selection::Part& part) {
  return role == LayoutRole::channels ? !part.channels.empty() : role != LayoutRole::byte_order;
}

}  // namespace

ProjectionPlan::ProjectionPlan(const StructType& type, FieldMask mask) : mask_(std::move(mask)) {
  add_all(type);
}

ProjectionPlan::ProjectionPlan(const TypeSupport& type, const Selection& selection)
    : mask_(selection.mask()), parts_hash_(selection.parts_hash()) {
  for (const Selection::Part& part : selection.parts()) {
    const Layout* const layout = type.layout_of(part.leaf);
    parts_.push_back({part, field_at(type.type(), part.leaf), layout});
  }
  add_all(type.type());
}

bool ProjectionPlan::can_stay_in_place() const {
  return std::ranges::none_of(
      parts_, [](const PlannedPart& planned) { return planned.data.member->kind == Kind::string; });
}

FieldMask ProjectionPlan::whole() const {
  FieldMask mask = mask_;
  for (const PlannedPart& planned : parts_) mask.erase(planned.part.leaf);
  return mask;
}

void ProjectionPlan::add_all(const StructType& type) {
  std::size_t leaf = 0;
  std::size_t slot = 0;
  add(type, leaf, slot);
  slots_ = slot;
  for (Step& step : steps_) {
    if (step.member == nullptr) measure(step.run);
  }
}

ProjectionPlan::Change ProjectionPlan::change_of(std::size_t leaf) const {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const PlannedPart& planned = parts_[i];
    if (planned.data.leaf == leaf) return {.part = i};
    if (planned.layout == nullptr) continue;
    if (const auto role = planned.layout->role_of(leaf); role && is_rewritten(*role, planned.part))
      return {.part = i, .role = role, .coordinate = leaf - (*planned.layout)[*role].leaf};
  }
  return {};
}

void ProjectionPlan::add(const StructType& type, std::size_t& leaf, std::size_t& slot) {
  for (const Member& m : type.members) {
    if (m.kind == Kind::structure && m.shape == Shape::single) {
      add(*m.type, leaf, slot);
      continue;
    }
    if (mask_.any_of(leaf, leaf_count(m))) {
      if (const Change change = change_of(leaf); change.part) {
        steps_.push_back({.slot = slot, .leaf = leaf, .member = &m, .change = change});
      } else if (is_primitive(m.kind) && m.shape != Shape::sequence) {
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

/// Copies selected members from a source position to the end of the projected body, each with its
/// alignment. Most plans have no parts. For these plans the code for parts is not compiled in.
template <bool with_parts>
class Projection::Writer {
 public:
  Writer(Projection& out, const SampleState& source, const ProjectionPlan& plan)
      : out_(out), s_(source), plan_(plan), mask_(plan.mask_) {}
  /// Makes a writer that writes everything to `memory`, and nothing to the staging buffer.
  Writer(Projection& out, const SampleState& source, const ProjectionPlan& plan, std::span<std::byte> memory,
         const PostponedCopies* postponed)
      : Writer(out, source, plan) {
    memory_ = memory;
    postponed_ = postponed;
  }

  /// Makes this writer leave the parts empty. Returns the writer.
  Writer& without_parts() {
    without_parts_ = true;
    return *this;
  }

  bool all() {
    for (const ProjectionPlan::Step& step : plan_.steps_) {
      const std::uint32_t offset = __atomic_load_n(s_.index + step.slot, __ATOMIC_RELAXED);
      if (offset == no_offset) return false;
      from_ = offset;
      if (!this->step(step)) return false;
    }
    return !with_parts || !failed_;
  }

  /// Sets the pointers of the staged segments. Called after the last growth of the staging buffer, which
  /// may move it.
  void finish() {
    close_staged();
    out_.bytes_ = to_;
    const std::byte* staged = memory().data();
    for (Segment& segment : out_.segments_) {
      if (segment.data != nullptr) continue;
      segment.data = staged;
      staged += segment.bytes;
    }
  }

 private:
  bool step(const ProjectionPlan::Step& step) {
    if (step.member == nullptr) return run(step.run);
    if constexpr (!with_parts) return member(*step.member, step.leaf, true);
    const ProjectionPlan::Change& change = step.change;
    if (without_parts_ && change.part && !change.role) return put(std::uint32_t{0});
    if (!change.part || out_.cuts_[*change.part].is_whole()) return member(*step.member, step.leaf, true);
    const Cut& cut = out_.cuts_[*change.part];
    if (!change.role && step.member->kind == Kind::string)
      return some_strings(plan_.parts_[*change.part].part.columns);
    if (!change.role) return part(cut, size_of(step.member->kind));
    switch (*change.role) {
      case LayoutRole::channels:
        return channels(cut);
      case LayoutRole::encoding:
        return encoding(cut);
      case LayoutRole::origin:
        return real(*step.member, cut.position()[change.coordinate]);
      case LayoutRole::rows:
      case LayoutRole::columns:
      case LayoutRole::cell_bytes:
      case LayoutRole::row_bytes:
        return put(cut.natural(*change.role));
      default:
        return real(*step.member, cut.real(*change.role));
    }
  }

  template <class T>
  bool put(T value) {
    align(sizeof value);
    stage(&value, sizeof value);
    return true;
  }

  bool real(const Member& m, double value) {
    return m.kind == Kind::float64 ? put(value) : put(static_cast<float>(value));
  }

  bool encoding(const Cut& cut) {
    const Extent name = checked_length(s_, from_);
    if (!name || checked_block(s_, name.first, name.count, 1) == no_offset) return false;
    put(name.count);
    const std::size_t begin = staged_;
    stage(s_.body + name.first, name.count);
    const std::size_t end = Cut::pattern_at + Cut::pattern_letters;
    if (cut.pattern() != nullptr && name.count >= end)
      std::memcpy(&memory()[begin + Cut::pattern_at], cut.pattern(), Cut::pattern_letters);
    return true;
  }

  bool channels(const Cut& cut) {
    put(static_cast<std::uint32_t>(cut.channels().size()));
    std::uint32_t offset = 0;
    for (const Cut::Channel& channel : cut.channels()) {
      put(channel.name.count);
      stage(s_.body + channel.name.first, channel.name.count);
      put(offset);
      put(channel.type);
      put(channel.count);
      offset += channel.bytes;
    }
    return true;
  }

  bool part(const Cut& cut, std::size_t element_bytes) {
    put(cut.elements());
    if (cut.bytes() == 0) return true;
    align(element_bytes);
    const bool has_whole_cells = cut.runs().size() == 1 && cut.runs()[0].bytes == cut.column_stride();
    if (!has_whole_cells) {
      const std::uint64_t from_first_to_last = (cut.rows() - std::uint64_t{1}) * cut.row_stride() +
                                               (cut.columns() - std::uint64_t{1}) * cut.column_stride() +
                                               cut.runs().back().offset + cut.runs().back().bytes;
      const std::byte* const from = source(cut.begin(), from_first_to_last);
      std::byte* const to = take_staging(cut.bytes());
      if (from == nullptr || to == nullptr) return false;
      gather(cut, to, from);
      return true;
    }
    const std::uint64_t row_bytes = std::uint64_t{cut.columns()} * cut.cell_bytes();
    if (row_bytes == cut.row_stride()) {
      copy(cut.begin(), cut.bytes());
    } else {
      for (std::uint32_t row = 0; row < cut.rows(); ++row)
        copy(cut.begin() + row * cut.row_stride(), row_bytes);
    }
    return true;
  }

  bool some_strings(const Selection::Range& range) {
    const Extent all = checked_length(s_, from_);
    if (!all) return false;
    put(range.size_of(all.count));
    from_ = all.first;
    const std::uint32_t end = std::min(range.end, all.count);
    for (std::uint32_t i = 0; i < end; ++i) {
      const bool is_kept = i >= range.begin && (i - range.begin) % range.step == 0;
      if (is_kept && !strings(1)) return false;
      if (is_kept) continue;
      from_ = skip_string(s_, from_);
      if (from_ == no_offset) return false;
    }
    return true;
  }

  /// Returns memory for `bytes` bytes; null if there is too little memory.
  std::byte* take_staging(std::size_t bytes) {
    if (!make_room(bytes)) return nullptr;
    std::byte* const to = memory().data() + staged_;
    staged_ += bytes;
    to_ += bytes;
    return to;
  }

  bool has_memory() const { return with_parts && memory_.data() != nullptr; }
  std::span<std::byte> memory() { return has_memory() ? memory_ : std::span(out_.staging_); }

  /// Returns the address of these bytes of the body; null if these bytes are in several places.
  const std::byte* source(std::uint64_t first, std::size_t bytes) const {
    const std::byte* const data = s_.body + first;
    return !with_parts || postponed_ == nullptr ? data : postponed_->locate(data, bytes);
  }

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

  /// Projects a member. `has_slot` is true if the next member is found by the index, so that the end of the
  /// present member is not needed.
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
      if (from_ == before) break;  // the loop ends for elements without bytes, whose number may be huge
    }
    return true;
  }

  bool same_selection(std::size_t leaf, std::size_t leaves) const {
    // If all leaves are in the mask, the source has all of them, too, and the whole range is copied.
    if (mask_.all_of(leaf, leaves)) return true;
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
    if (bytes < reference_bytes_min || has_memory()) {
      stage(source(first, bytes), bytes);
    } else {
      close_staged();
      out_.segments_.push_back({s_.body + first, bytes});
      to_ += bytes;
    }
    from_ = first + bytes;
  }

  void stage(const void* data, std::size_t bytes) {
    if (bytes == 0) return;
    std::byte* const to = with_parts && data == nullptr ? nullptr : take_staging(bytes);
    if (with_parts && to == nullptr) {
      failed_ = true;
    } else {
      std::memcpy(to, data, bytes);
    }
  }

  bool make_room(std::size_t bytes) {
    if (memory().size() - staged_ >= bytes) return true;
    if (has_memory()) return false;
    out_.staging_.resize(2 * out_.staging_.size() + bytes);
    return true;
  }

  /// Makes a segment of the bytes that were staged since the last call.
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
  std::size_t closed_ = 0;  ///< bytes in the staging buffer that already belong to segments
  std::span<std::byte> memory_{};
  const PostponedCopies* postponed_ = nullptr;
  bool without_parts_ = false;
  bool failed_ = false;  ///< true if there was too little memory
};

void Projection::reserve(const Memory& memory) {
  segments_.clear();
  segments_.reserve(memory.segments);
  if (staging_.size() < memory.staging_bytes) staging_.resize(memory.staging_bytes);
}

bool Projection::find_cuts(const SampleState& source, const ProjectionPlan& plan) {
  if (cuts_.size() < plan.parts_.size()) cuts_.resize(plan.parts_.size());
  for (std::size_t i = 0; i < plan.parts_.size(); ++i) {
    const ProjectionPlan::PlannedPart& planned = plan.parts_[i];
    if (!cuts_[i].find(source, planned.layout, planned.data, planned.part)) return false;
  }
  return true;
}

template <bool with_parts>
bool Projection::write(Writer<with_parts> writer) {
  const bool ok = writer.all();
  writer.finish();
  return ok;
}

bool Projection::project(const SampleState& source, const ProjectionPlan& plan) {
  segments_.clear();
  bytes_ = 0;
  if (!source.mask->contains(plan.mask())) return false;
  if (!plan.has_parts()) return write(Writer<false>(*this, source, plan));
  if (!find_cuts(source, plan)) return false;
  return write(Writer<true>(*this, source, plan));
}

bool Projection::project_around_parts(const SampleState& source, const ProjectionPlan& plan) {
  segments_.clear();
  bytes_ = 0;
  if (!source.mask->contains(plan.mask()) || !find_cuts(source, plan)) return false;
  return write(Writer<true>(*this, source, plan).without_parts());
}

bool Projection::project(const SampleState& source, const ProjectionPlan& plan, std::span<std::byte> memory,
                         const PostponedCopies* postponed) {
  segments_.clear();
  bytes_ = 0;
  if (!source.mask->contains(plan.mask()) || !find_cuts(source, plan)) return false;
  return write(Writer<true>(*this, source, plan, memory, postponed));
}

std::size_t Projection::bytes_most(const SampleState& source, const ProjectionPlan& plan) {
  if (!source.mask->contains(plan.mask()) || !find_cuts(source, plan)) return 0;
  // The maximum padding before each member and before each length, in bytes.
  constexpr std::size_t padding = 7;
  std::uint64_t bytes = 2 * padding * (plan.steps_.size() + plan.blocks_.size() + 1);
  for (const ProjectionPlan::Step& step : plan.steps_) bytes += plan.bytes_of(step, source);
  for (std::size_t i = 0; i < plan.parts_.size(); ++i) bytes -= std::min(bytes, cuts_[i].bytes_less());
  return bytes;
}

/// Returns the bytes of the step's fields in the source. They end where the next field begins that the source
/// has.
std::uint64_t ProjectionPlan::bytes_of(const Step& step, const SampleState& source) const {
  const auto begin_of = [&](std::size_t slot) {
    return __atomic_load_n(source.index + slot, __ATOMIC_RELAXED);
  };
  std::size_t behind = step.slot + std::max(1U, step.run.blocks);
  while (behind < slots_ && begin_of(behind) == no_offset) ++behind;
  const std::uint32_t end = behind < slots_ ? begin_of(behind) : source.body_bytes;
  return end - std::min(end, begin_of(step.slot));
}

}  // namespace sft::detail
