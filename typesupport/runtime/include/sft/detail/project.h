// Makes the CDR of a smaller mask from one encoded sample, without reading other fields. Small runs are
// copied to a staging buffer; large ones are referenced in the source. If only a part of a field is
// requested (cut.h), the bytes of the part are gathered in the staging buffer, unless they are contiguous.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sft/detail/cut.h"
#include "sft/detail/walk.h"
#include "sft/type_support.h"

namespace sft::detail {

class PostponedCopies;

struct Segment {
  const std::byte* data = nullptr;
  std::size_t bytes = 0;
};

/// Runs of at least this many bytes are referenced in the source rather than copied.
inline constexpr std::size_t reference_bytes_min = 4096;

/// The runs that have to be gathered for one mask, for any source. They are determined once, when the mask
/// becomes known. A plan is immutable; any number of projections may use it at a time.
class ProjectionPlan {
 public:
  /// `type` must outlive the plan. `mask` must be closed.
  ProjectionPlan(const StructType& type, FieldMask mask);
  /// Makes the plan for a closed selection, whose gate is not used.
  ProjectionPlan(const TypeSupport& type, const Selection& selection);

  const FieldMask& mask() const { return mask_; }
  /// Returns the fields that are taken whole.
  FieldMask whole() const;
  bool has_parts() const { return !parts_.empty(); }
  std::size_t parts() const { return parts_.size(); }
  /// Returns the field of part number i.
  const Layout::Field& data(std::size_t i) const { return parts_[i].data; }
  /// Returns true if views can read the parts in place. Views cannot read parts of sequences of texts in
  /// place.
  bool can_stay_in_place() const;
  std::uint64_t parts_hash() const { return parts_hash_; }  ///< the value of Selection::parts_hash()

 private:
  friend class Projection;

  struct PlannedPart {
    Selection::Part part;
    Layout::Field data{};
    const Layout* layout = nullptr;
  };
  /// A change because of a part: of the field itself, or of a field that depends on it.
  struct Change {
    std::optional<std::size_t> part{};  ///< the number of the part; empty: nothing changes
    /// The role of the changed field; empty: the change is in the field itself.
    std::optional<LayoutRole> role{};
    std::size_t coordinate = 0;  ///< the number of the coordinate of an origin, 0 to 2
  };

  /// A leaf with a known size: a primitive or an array of primitives.
  struct Block {
    std::uint64_t bytes;
    std::uint32_t alignment;
  };
  /// Blocks of neighbouring leaves, which are adjacent in every source that has them.
  struct Run {
    std::uint32_t first_block = 0;
    std::uint32_t blocks = 0;
    std::uint32_t alignment = 1;  ///< the largest alignment of the run's blocks
    /// Number of bytes with padding, indexed by the offset of the run modulo 8.
    std::array<std::uint64_t, 8> bytes_at{};
  };
  struct Step {
    std::size_t slot = 0;  ///< the slot of the first block in the source
    std::size_t leaf = 0;
    const Member* member = nullptr;  ///< the member of the step; null: the step is a run
    Run run{};
    Change change{};
  };

  void add(const StructType& type, std::size_t& leaf, std::size_t& slot);
  void add_block(const Member& m, std::size_t leaf, std::size_t slot);
  void measure(Run& run) const;
  void add_all(const StructType& type);
  Change change_of(std::size_t leaf) const;
  std::uint64_t bytes_of(const Step& step, const SampleState& source) const;

  FieldMask mask_;
  std::uint64_t parts_hash_ = 0;
  std::vector<PlannedPart> parts_;
  std::vector<Step> steps_;
  std::vector<Block> blocks_;
  std::size_t next_slot_ = 0;  ///< the slot that follows the last block, while steps are added
  std::size_t slots_ = 0;      ///< the number of index slots of the type
};

class Projection {
 public:
  /// Projects `source` to the plan's mask. Uses source.index, which must be valid. Returns false if the
  /// source does not have all fields of the mask, or if its bytes are malformed. Allocates nothing if the
  /// memory of earlier projections suffices.
  bool project(const SampleState& source, const ProjectionPlan& plan);

  /// Projects with a plan that has parts, and writes the whole body to `memory`, in one piece. bytes_most()
  /// bytes suffice for nearly all messages; returns false if they do not. If `memory` is empty, the
  /// projection uses memory of its own. Bytes that the source still lacks because their copies are
  /// `postponed` are read from their original place.
  bool project(const SampleState& source, const ProjectionPlan& plan, std::span<std::byte> memory,
               const PostponedCopies* postponed = nullptr);
  /// Projects the fields around the parts of the plan, and leaves the parts empty. After the call cuts()
  /// are valid.
  bool project_around_parts(const SampleState& source, const ProjectionPlan& plan);
  /// Returns the places of the plan's parts in the source that was projected last.
  std::span<const Cut> cuts(const ProjectionPlan& plan) const { return std::span(cuts_).first(plan.parts()); }
  /// Returns the maximum number of bytes of the body of a plan with parts, without the padding of structs
  /// in sequences. Returns 0 if project() would fail.
  std::size_t bytes_most(const SampleState& source, const ProjectionPlan& plan);

  /// Projects with a plan that exists only for this call.
  bool project(const SampleState& source, const StructType& type, const FieldMask& mask) {
    return project(source, ProjectionPlan(type, mask));
  }

  /// The memory of a projection. It grows with the masks and samples that were projected.
  struct Memory {
    std::size_t staging_bytes = 0;
    std::size_t segments = 0;

    std::size_t bytes() const { return staging_bytes + segments * sizeof(Segment); }
    bool suffices_for(const Memory& other) const {
      return staging_bytes >= other.staging_bytes && segments >= other.segments;
    }
  };
  Memory memory() const { return {staging_.size(), segments_.capacity()}; }
  /// Reserves at least this much memory. A sample that a Projection with this memory projects without an
  /// allocation needs no allocation here either. Invalidates segments().
  void reserve(const Memory& memory);

  /// Returns the projected body, in order. Valid until the next project() and as long as the source.
  std::span<const Segment> segments() const { return segments_; }
  std::size_t bytes() const { return bytes_; }

 private:
  template <bool with_parts>
  class Writer;
  template <bool with_parts>
  bool write(Writer<with_parts> writer);
  bool find_cuts(const SampleState& source, const ProjectionPlan& plan);

  std::vector<Cut> cuts_;           ///< one for each part of the plan
  std::vector<std::byte> staging_;  ///< grows, and never shrinks
  std::vector<Segment> segments_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::detail
