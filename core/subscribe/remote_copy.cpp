#include "core/subscribe/remote_copy.h"

#include <cstring>
#include <utility>

#include "sft/detail/untyped.h"

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

void PartReader::begin(std::shared_ptr<RemoteCopy> owner, SampleHandle source,
                       std::shared_ptr<const Asked> asked, std::span<const detail::Cut> cuts) {
  owner_ = std::move(owner);
  source_ = std::move(source);
  source_state_ = owner_->state(*source_);
  asked_ = std::move(asked);
  cuts_.assign(cuts.begin(), cuts.end());
}

std::optional<std::size_t> PartReader::number_of(std::size_t leaf) const {
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    if (asked_->plan->data(i).leaf == leaf) return i;
  }
  return {};
}

detail::PartInPlace PartReader::place(std::size_t part) const {
  return {.source = &source_state_, .data = asked_->plan->data(part), .cut = &cuts_[part]};
}

std::optional<detail::PartInPlace> PartReader::find(std::size_t leaf) noexcept {
  const std::optional<std::size_t> part = number_of(leaf);
  if (!part) return {};
  return place(*part);
}

std::optional<std::span<const std::byte>> PartReader::bytes_of(std::size_t leaf) noexcept {
  const std::optional<std::size_t> part = number_of(leaf);
  if (!part) return {};
  if (const auto bytes = place(*part).contiguous()) return bytes;
  return cuts_[*part].is_whole() ? std::span<const std::byte>() : gathered(*part);
}

std::span<const std::byte> PartReader::gathered(std::size_t part) noexcept {
  const std::size_t bytes = cuts_[part].bytes();
  const Lock lock(mutex_);
  if (copies_.size() < cuts_.size()) copies_.resize(cuts_.size());
  SampleHandle& copy = copies_[part];
  if (!copy) {
    copy = owner_->memory(sizeof(detail::SampleHeader) + bytes);
    if (!copy) return {};
    place(part).gather_to(copy->data + sizeof(detail::SampleHeader));
  }
  return {copy->data + sizeof(detail::SampleHeader), bytes};
}

const detail::SampleState& PartReader::put_together() noexcept {
  {
    const Lock lock(mutex_);
    if (was_put_together_) return together_state_;
  }
  // The owner has its own lock. If several threads are here at the same time, the first copy is used.
  SampleHandle copy = owner_->of(source_, *asked_->plan);
  const Lock lock(mutex_);
  if (was_put_together_) return together_state_;
  was_put_together_ = true;
  together_ = std::move(copy);
  together_state_ = together_ ? owner_->state(*together_) : detail::untyped::empty_state;
  if (!together_) together_state_.mask = &asked_->plan->mask();  // the fields are present, but cannot be read
  return together_state_;
}

void PartReader::end(PartReader* reader) noexcept {
  {
    const Lock lock(reader->mutex_);
    for (SampleHandle& copy : reader->copies_) copy.reset();
    reader->together_.reset();
    reader->was_put_together_ = false;
  }
  reader->source_.reset();
  reader->asked_.reset();
  const std::shared_ptr<RemoteCopy> owner =
      std::move(reader->owner_);  // may hold the last reference to the owner
  owner->take_back(*reader);
}

}  // namespace sft::core
