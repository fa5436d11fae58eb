#include "core/subscribe/remote_copy.h"

#include <cstring>

namespace sft::core {

SampleHandle RemoteCopy::of(SampleHandle sample, const ProjectionPlan& asked) {
  if (asked.mask().contains(sample->mask)) return sample;
  if (!project(*sample, asked)) return {};
  SampleHandle copy = pool_->take(SampleLayout(type_.slots()).bytes(projection_.bytes()));
  if (!copy) return {};
  copy->mask = sample->mask & asked.mask();
  return fill(*copy, *sample) ? std::move(copy) : SampleHandle();
}

bool RemoteCopy::project(const SampleBuffer& sample, const ProjectionPlan& asked) {
  const SampleState state = state_of(sample, type_.slots());
  if (sample.mask.contains(asked.mask())) return projection_.project(state, asked);
  return projection_.project(state, type_.type(), sample.mask & asked.mask());
}

/// With what was projected. False if that is not what it claims to be.
bool RemoteCopy::fill(SampleBuffer& copy, const SampleBuffer& sample) const {
  const SampleLayout layout(type_.slots());
  SampleHeader& header = copy.header();
  header.slots = static_cast<std::uint32_t>(type_.slots());
  header.type_hash = type_.hash();
  header.writer = sample.writer;
  header.sequence = sample.sequence;
  header.source_stamp_ns = sample.source_stamp_ns;
  header.body_offset = static_cast<std::uint32_t>(layout.body_offset);
  header.body_bytes = static_cast<std::uint32_t>(projection_.bytes());
  copy.trust_header();
  copy.receive_stamp_ns = sample.receive_stamp_ns;
  std::byte* to = copy.data + layout.body_offset;
  std::memcpy(to - encapsulation_bytes, encapsulation_cdr_le.data(), encapsulation_bytes);
  for (const Segment& segment : projection_.segments()) {
    std::memcpy(to, segment.data, segment.bytes);
    to += segment.bytes;
  }
  return build_index(state_of(copy, type_.slots()), type_.type(), {copy.index(), type_.slots()}) ==
         WalkStatus::ok;
}

}  // namespace sft::core
