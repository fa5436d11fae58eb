#include "core/subscribe/remote_copy.h"

#include <cstring>

namespace sft::core {

bool RemoteCopy::is_as_asked(const SampleBuffer& sample, const detail::ProjectionPlan& asked) {
  return sample.parts != 0 || (asked.parts_hash() == 0 && asked.mask().contains(sample.mask));
}

SampleHandle RemoteCopy::of(SampleHandle sample, const detail::ProjectionPlan& asked) {
  if (is_as_asked(*sample, asked)) return sample;
  const FieldMask present = sample->mask.contains(asked.mask()) ? asked.mask() : sample->mask & asked.whole();
  const Lock lock(mutex_);
  if (!project(*sample, asked, present)) return {};
  return copy(*sample, present, present == asked.mask() ? asked.parts_hash() : 0);
}

RemoteCopy::InPlace RemoteCopy::in_place(SampleHandle sample, std::shared_ptr<const Asked> asked) {
  const detail::ProjectionPlan& plan = *asked->plan;
  const bool can_stay = plan.has_parts() && plan.can_stay_in_place() && sample->mask.contains(plan.mask());
  if (!can_stay || is_as_asked(*sample, plan)) return {of(std::move(sample), plan)};
  const Lock lock(mutex_);
  if (!projection_.project_around_parts(state(*sample), plan)) return {};
  InPlace around{copy(*sample, plan.mask(), plan.parts_hash())};
  if (!around.sample) return {};
  around.parts = &take_reader();
  around.parts->begin(shared_from_this(), std::move(sample), std::move(asked), projection_.cuts(plan));
  return around;
}

PartReader& RemoteCopy::take_reader() {
  const Lock lock(readers_mutex_);
  if (free_.empty()) {
    free_.reserve(readers_.size() + 1);  // reserved now, so that returning the reader allocates nothing
    return *readers_.emplace_back(std::make_unique<PartReader>());
  }
  PartReader& reader = *free_.back();
  free_.pop_back();
  return reader;
}

void RemoteCopy::take_back(PartReader& reader) noexcept {
  const Lock lock(readers_mutex_);
  free_.push_back(&reader);
}

bool RemoteCopy::project(const SampleBuffer& sample, const detail::ProjectionPlan& asked,
                         const FieldMask& present) {
  const detail::SampleState state = state_of(sample, type_.index_slots());
  if (present == asked.mask()) return projection_.project(state, asked);
  return projection_.project(state, type_.type(), present);
}

SampleHandle RemoteCopy::copy(const SampleBuffer& sample, const FieldMask& mask, std::uint64_t parts) {
  SampleHandle copy = pool_->take(detail::SampleLayout(type_.index_slots()).bytes(projection_.bytes()));
  if (!copy) return {};
  copy->mask = mask;
  copy->parts = parts;
  return fill(*copy, sample) ? std::move(copy) : SampleHandle();
}

/// Fills the copy with the projected bytes. Returns false if the bytes are malformed.
bool RemoteCopy::fill(SampleBuffer& copy, const SampleBuffer& sample) const {
  const detail::SampleLayout layout(type_.index_slots());
  detail::SampleHeader& header = copy.header();
  header.index_slots = static_cast<std::uint16_t>(type_.index_slots());
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
  return detail::build_index(state_of(copy, type_.index_slots()), type_.type(),
                             {copy.index(), type_.index_slots()}) == detail::WalkStatus::ok;
}

}  // namespace sft::core
