#include "sft/dynamic.h"

#include <cstring>

#include "sft/detail/project.h"
#include "sft/detail/sample_format.h"

namespace sft {

namespace {

/// Returns encapsulation and body of the fields in `mask`. The result is empty if the sample is malformed.
std::vector<std::byte> projected(const detail::SampleState& state, const StructType& type,
                                 const FieldMask& mask) {
  detail::Projection projection;
  if (!projection.project(state, type, mask & *state.mask)) {
    state.flag_malformed();
    return {};
  }
  std::vector<std::byte> bytes(detail::encapsulation_bytes + projection.bytes());
  std::memcpy(bytes.data(), detail::encapsulation_cdr_le.data(), detail::encapsulation_bytes);
  std::byte* to = bytes.data() + detail::encapsulation_bytes;
  for (const detail::Segment& segment : projection.segments()) {
    std::memcpy(to, segment.data, segment.bytes);
    to += segment.bytes;
  }
  return bytes;
}

}  // namespace

std::span<const std::byte> DynamicSample::cdr() const& {
  const detail::SampleState& state = sample_.state();
  if (!sample_ || fields().contains(*state.mask)) return sample_.cdr();
  return declared_cdr_.get([&] { return projected(state, type_.type(), fields()); });
}

}  // namespace sft
