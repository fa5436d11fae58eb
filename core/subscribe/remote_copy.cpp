#include "core/subscribe/remote_copy.h"

#include <cstring>

namespace sft::core {

SampleHandle RemoteCopy::of(SampleHandle sample, const detail::ProjectionPlan& asked) {
  const bool is_as_asked = sample->parts == asked.parts_hash() && asked.mask().contains(sample->mask);
  if (is_as_asked || sample->parts != 0) return sample;
  const FieldMask present = sample->mask.contains(asked.mask()) ? asked.mask() : sample->mask & asked.whole();
  if (!project(*sample, asked, present)) return {};
  SampleHandle copy = pool_->take(detail::SampleLayout(type_.slots()).bytes(projection_.bytes()));
  if (!copy) return {};
  copy->mask = present;
  copy->parts = present == asked.mask() ? asked.parts_hash() : 0;
  return fill(*copy, *sample) ? std::move(copy) : SampleHandle();
}

bool RemoteCopy::project(const SampleBuffer& sample, const detail::ProjectionPlan& asked,
                         const FieldMask& present) {
  const detail::SampleState state = state_of(sample, type_.slots());
  if (present == asked.mask()) return projection_.project(state, asked);
  return projection_.project(state, type_.type(), present);
}

/// Fills the copy with the projected bytes. Returns false if these are not what they claim to be.
bool RemoteCopy::fill(SampleBuffer& copy, const SampleBuffer& sample) const {
  const detail::SampleLayout layout(type_.slots());
  detail::SampleHeader& header = copy.header();
  header.slots = static_cast<std::uint16_t>(type_.slots());
  header.type_hash = type_.hash();
  header.writer = sample.writer;
  header.sequence = sample.sequence;
  header.source_stamp_ns = sample.source_stamp_ns;
  header.body_offset = static_cast<std::uint32_t>(layout.body_offset);
  header.body_bytes = static_cast<std::uint32_t>(projection_.bytes());
  copy.trust_header();
  copy.receive_stamp_ns = sample.receive_stamp_ns;
  std::byte* to = copy.data + layout.body_offset;
  std::memcpy(to - detail::encapsulation_bytes, detail::encapsulation_cdr_le.data(),
              detail::encapsulation_bytes);
  for (const detail::Segment& segment : projection_.segments()) {
    std::memcpy(to, segment.data, segment.bytes);
    to += segment.bytes;
  }
  return detail::build_index(state_of(copy, type_.slots()), type_.type(), {copy.index(), type_.slots()}) ==
         detail::WalkStatus::ok;
}

}  // namespace sft::core
