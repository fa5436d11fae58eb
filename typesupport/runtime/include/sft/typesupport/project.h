// From one encoded sample to the CDR of a smaller mask, without touching what is not asked for: small runs
// are copied to a staging buffer, large ones are named where they lie in the source.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sft/typesupport/type_support.h"
#include "sft/typesupport/walk.h"

namespace sft {

struct Segment {
  const std::byte* data = nullptr;
  std::size_t bytes = 0;
};

/// Runs of at least this many bytes are referenced in the source rather than copied.
inline constexpr std::size_t reference_bytes_min = 4096;

class Projection {
 public:
  /// Projects `source` to `mask`, which is closed and a subset of the source's mask; source.index is used and
  /// must be valid. False if the source's bytes are not what they claim to be. In steady state nothing is
  /// allocated.
  bool project(const SampleState& source, const StructType& type, const FieldMask& mask);

  /// The projected body, in order. Valid until the next project() and while the source lives.
  std::span<const Segment> segments() const { return segments_; }
  std::size_t bytes() const { return bytes_; }

 private:
  class Writer;
  std::vector<std::byte> staging_;
  std::vector<Segment> segments_;
  std::size_t bytes_ = 0;
};

}  // namespace sft
