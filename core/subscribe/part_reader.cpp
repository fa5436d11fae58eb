#include "core/subscribe/part_reader.h"

#include <utility>

#include "sft/detail/project.h"
#include "sft/detail/untyped.h"

namespace sft::core {

void PartReader::begin(std::shared_ptr<Owner> owner, SampleHandle source, std::shared_ptr<const Asked> asked,
                       std::span<const detail::Cut> cuts) {
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
  const std::shared_ptr<Owner> owner = std::move(reader->owner_);  // may hold the last reference to the owner
  owner->take_back(*reader);
}

}  // namespace sft::core
