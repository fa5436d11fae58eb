// From one encoded sample to the CDR of a smaller mask, without touching what is not asked for: small runs
// are copied to a staging buffer, large ones are named where they lie in the source.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sft/detail/walk.h"
#include "sft/type_support.h"

namespace sft::detail {

struct Segment {
  const std::byte* data = nullptr;
  std::size_t bytes = 0;
};

/// Runs of at least this many bytes are referenced in the source rather than copied.
inline constexpr std::size_t reference_bytes_min = 4096;

/// The runs that have to be gathered for one mask, whatever else the source has. They are found once, when
/// the mask becomes known. Immutable; any number of projections may use a plan at a time.
class ProjectionPlan {
 public:
  /// `type` outlives the plan. `mask` is closed.
  ProjectionPlan(const StructType& type, FieldMask mask);

  const FieldMask& mask() const { return mask_; }

 private:
  friend class Projection;

  /// A leaf of which the size is known: a primitive or an array of them.
  struct Block {
    std::uint64_t bytes;
    std::uint32_t alignment;
  };
  /// Blocks of neighbouring leaves, which lie behind one another in every source that has them.
  struct Run {
    std::uint32_t first_block = 0;
    std::uint32_t blocks = 0;
    std::uint32_t alignment = 1;              ///< the largest of its blocks
    std::array<std::uint64_t, 8> bytes_at{};  ///< padding included, where it begins at this offset modulo 8
  };
  struct Step {
    std::size_t slot = 0;  ///< where it begins in the source
    std::size_t leaf = 0;
    const Member* member = nullptr;  ///< null: a run
    Run run{};
  };

  void add(const StructType& type, std::size_t& leaf, std::size_t& slot);
  void add_block(const Member& m, std::size_t leaf, std::size_t slot);
  void measure(Run& run) const;

  FieldMask mask_;
  std::vector<Step> steps_;
  std::vector<Block> blocks_;
  std::size_t next_slot_ = 0;  ///< behind the last block, while steps are added
};

class Projection {
 public:
  /// Projects `source` to the plan's mask; source.index is used and must be valid. False if the source does
  /// not have all of the mask, or its bytes are not what they claim to be. In steady state nothing is
  /// allocated.
  bool project(const SampleState& source, const ProjectionPlan& plan);

  /// Projects once, with a plan of its own.
  bool project(const SampleState& source, const StructType& type, const FieldMask& mask) {
    return project(source, ProjectionPlan(type, mask));
  }

  /// The memory of a projection, which grows with the masks and samples that it has seen.
  struct Memory {
    std::size_t staging_bytes = 0;
    std::size_t segments = 0;

    std::size_t bytes() const { return staging_bytes + segments * sizeof(Segment); }
    bool suffices_for(const Memory& other) const {
      return staging_bytes >= other.staging_bytes && segments >= other.segments;
    }
  };
  Memory memory() const { return {staging_.size(), segments_.capacity()}; }
  /// Takes at least so much memory: what another projection could project with it needs no more here. Ends
  /// the validity of segments().
  void reserve(const Memory& memory);

  /// The projected body, in order. Valid until the next project() and while the source lives.
  std::span<const Segment> segments() const { return segments_; }
  std::size_t bytes() const { return bytes_; }

 private:
  class Writer;
  std::vector<std::byte> staging_;  ///< grows and keeps its size
  std::vector<Segment> segments_;
  std::size_t bytes_ = 0;
};

}  // namespace sft::detail
