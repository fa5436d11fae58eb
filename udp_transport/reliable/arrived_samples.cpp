#include "udp_transport/reliable/arrived_samples.h"

#include <algorithm>

#include "udp_transport/reliable/ordinal_monitor.h"

namespace sft::udp {

bool ArrivedSamples::begin_with(Place place) {
  if (place < next_ || !slots_.empty()) return false;
  slots_.begin_at(place);
  next_ = end_ = skip_to_ = place;
  return true;
}

bool ArrivedSamples::reach(Place end, Time now) {
  end_ = std::max(end_, end);
  while (slots_.end() < end) {
    if (slots_.empty() && slots_.begin() < skip_to_) {
      slots_.begin_at(skip_to_);
      next_ = std::max(next_, skip_to_);
      continue;
    }
    if (slots_.size() >= samples_max_) return false;
    Slot& slot = slots_.push_back({.repair = schedule_.noticed(now)});
    if (slots_.end() <= skip_to_) slot.state = State::passed;
    look_at(slot.repair.ask_at);
  }
  advance();
  return true;
}

void ArrivedSamples::lose_before(Place end, bool all_counted) {
  for (Place place = next_; place < std::min(end, slots_.end()); ++place) {
    Slot& slot = slots_[place];
    if (slot.settled()) continue;
    if (slot.state == State::begun) dropped_.abandoned.push_back(slot.label);
    slot.state = State::passed;
    slot.sample.reset();
    ++lost_;
  }
  const Place unseen = std::max(slots_.end(), skip_to_);
  if (end > unseen && all_counted) lost_ += end - unseen;
  skip_to_ = std::max(skip_to_, end);
  end_ = std::max(end_, end);
  advance();
}

/// Gives up missing samples until the held samples are within the limit. Samples before the first missing
/// one do not count, because the readers can take them.
void ArrivedSamples::hold_no_more_than_allowed() {
  while (held_bytes_ - ready_bytes_ > held_bytes_max_) lose_before(next_ + 1, false);
}

void ArrivedSamples::release_before(Place end) {
  while (!slots_.empty() && slots_.begin() < end) {
    const Slot& slot = slots_[slots_.begin()];
    if (slot.state == State::whole) {
      held_bytes_ -= slot.sample->capacity;
      ready_bytes_ -= slot.sample->capacity;
    }
    slots_.pop_front();
  }
}

void ArrivedSamples::begun(Place place, const SampleLabel& label, core::SampleHandle buffer) {
  if (!slots_.contains(place)) return;
  Slot& slot = slots_[place];
  slot.state = State::begun;
  slot.label = label;
  slot.sample = std::move(buffer);
  slot.repair.asked = 0;
  look_at(slot.repair.ask_at);
}

bool ArrivedSamples::whole(Place place, core::SampleHandle sample) {
  if (!slots_.contains(place)) return false;
  Slot& slot = slots_[place];
  if (slot.state == State::passed) return false;  // the sample was given up, and is not needed any more
  held_bytes_ += sample->capacity;
  slot.sample = std::move(sample);
  slot.state = State::whole;
  schedule_.came_whole(slot.repair);
  advance();
  return true;
}

void ArrivedSamples::pass(Place place) {
  if (!slots_.contains(place)) return;
  slots_[place].state = State::passed;
  slots_[place].sample.reset();
  advance();
}

void ArrivedSamples::refuse(Place place) {
  if (!slots_.contains(place) || slots_[place].settled()) return;
  Slot& slot = slots_[place];
  slot.state = State::missing;
  slot.sample.reset();
  schedule_.noticed_again(slot.repair);
  look_at(slot.repair.ask_at);
}

bool ArrivedSamples::makes_no_sense_again(Place place) {
  return slots_.contains(place) && std::exchange(slots_[place].makes_no_sense, true);
}

void ArrivedSamples::unconfirm(Place place, std::uint32_t sequence) {
  if (place < next_ || !slots_.contains(place) || slots_[place].state != State::whole) return;
  if (static_cast<std::uint32_t>(slots_[place].sample->sequence) != sequence) come_again(place);
}

/// Samples before the first missing one are dropped, but not requested again, because they were
/// acknowledged.
void ArrivedSamples::distrust_above(std::uint64_t sequence) {
  for (Place place = slots_.begin(); place < slots_.end(); ++place) {
    const Slot& slot = slots_[place];
    if (slot.state == State::whole && slot.sample->sequence > sequence) come_again(place);
  }
}

void ArrivedSamples::forget_unpublished(Place from, Time now) {
  from = std::max(from, first_wanted());
  if (unpublished_end_ <= from) {  // the writer has published these samples meanwhile
    unpublished_end_ = end_ > from ? end_ : 0;
    unpublished_since_ = now;
    return;
  }
  if (now - unpublished_since_ < OrdinalMonitor::unconfirmed_after) return;
  for (; slots_.end() > from; slots_.pop_back()) {
    const Slot& last = slots_[slots_.end() - 1];
    if (last.state == State::whole) held_bytes_ -= last.sample->capacity;
    if (last.state == State::begun) dropped_.given_back.push_back(last.label);
  }
  end_ = from;
  unpublished_end_ = 0;
  advance();
}

/// Removes a whole sample that was wrong, so that it is requested again.
void ArrivedSamples::come_again(Place place) {
  Slot& slot = slots_[place];
  held_bytes_ -= slot.sample->capacity;
  if (place < next_) ready_bytes_ -= slot.sample->capacity;
  slot.state = place < next_ ? State::passed : State::missing;
  slot.sample.reset();
  slot.repair.asked = 0;
  schedule_.noticed_again(slot.repair);
  if (place >= next_) look_at(slot.repair.ask_at);
}

void ArrivedSamples::give_back(Place place, Time now) {
  Slot& slot = slots_[place];
  dropped_.given_back.push_back(slot.label);
  slot.state = State::missing;
  slot.sample.reset();
  slot.repair.asked = 0;
  slot.repair.ask_at = now;
}

void ArrivedSamples::came_again(Place place) {
  if (slots_.contains(place)) schedule_.came_again(slots_[place].repair);
}

void ArrivedSamples::asked_for(Place place, std::uint32_t parts) {
  if (slots_.contains(place)) RepairSchedule::asked_for(slots_[place].repair, parts);
}

void ArrivedSamples::advance() {
  next_ = std::max(next_, slots_.begin());
  for (; next_ < slots_.end() && slots_[next_].settled(); ++next_) {
    if (slots_[next_].state == State::whole) ready_bytes_ += slots_[next_].sample->capacity;
  }
  if (next_ == slots_.end()) schedule_.nothing_is_missing();
}

}  // namespace sft::udp
