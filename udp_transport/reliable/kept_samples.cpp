#include "udp_transport/reliable/kept_samples.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sft::udp {

KeptSamples::KeptSamples(const ResendLimits& limits, std::uint64_t first_ordinal,
                         std::shared_ptr<const KeptMemory> memory)
    : samples_max_(limits.samples),
      bytes_max_(limits.bytes),
      samples_least_(limits.samples_least),
      memory_(std::move(memory)),
      entries_(first_ordinal),
      waiting_{first_ordinal, first_ordinal},
      sent_(first_ordinal) {}

KeptSamples::Kept KeptSamples::keep(const JobHandle& job, const FirstHeader& first, bool elsewhere) {
  Kept kept{.ordinal = end()};
  const std::size_t before = bytes_;
  const auto samples = static_cast<std::uint32_t>(job->samples());
  for (std::uint32_t part = 0; part < samples; ++part) {
    bytes_ += job->held_bytes(part);
    entries_.push_back(
        {.first = header_behind(first, part, job->body_bytes(part)), .job = job, .part = part});
  }
  make_room(kept, bytes_ - before);
  kept.ordinal = std::max(kept.ordinal, begin());
  kept.elsewhere = elsewhere && amount() != Amount::more_than_half;
  if (kept.elsewhere) {
    entries_[kept.ordinal].elsewhere = true;
    start(entries_[kept.ordinal]);
  }
  return kept;
}

bool KeptSamples::keeps_more_than(std::size_t samples, std::size_t bytes) const {
  return size() > samples || bytes_ > bytes;
}

KeptSamples::Amount KeptSamples::amount() const {
  if (entries_.empty()) return Amount::nothing;
  const bool is_surplus = size() > samples_least_ / 2;
  const bool more = size() > samples_max_ / 2 || (is_surplus && bytes_ > bytes_max_ / 2);
  return more ? Amount::more_than_half : Amount::at_most_half;
}

bool KeptSamples::can_keep(std::size_t samples, std::size_t bytes) const {
  if (entries_.empty()) return true;
  samples += size();
  const std::size_t in_all = bytes_ + bytes;
  return samples <= samples_max_ && (in_all <= bytes_max_ || samples <= samples_least_) &&
         (memory_ == nullptr || !memory_->wants_some_of(in_all, bytes));
}

/// Returns the maximum number of bytes that the memory of the node lets this channel keep after `added` more
/// bytes. If all channels together keep too many bytes, this channel has to give up twice as many bytes as it
/// adds.
std::size_t KeptSamples::bytes_max_of_memory(std::size_t added) const {
  if (memory_ == nullptr || !memory_->wants_some_of(bytes_)) return std::numeric_limits<std::size_t>::max();
  return std::max(added, bytes_ - std::min(bytes_, 2 * added));
}

/// Returns true if more samples are kept than the limits allow, or than half of the limits.
bool KeptSamples::must_give_up(std::size_t bytes_max_of_memory, bool half) const {
  const std::size_t of = half ? 2 : 1;
  const bool is_surplus = size() > samples_least_;
  return keeps_more_than(samples_max_ / of, bytes_max_of_memory / of) ||
         (is_surplus && bytes_ > bytes_max_ / of);
}

/// Gives up the oldest samples until the others are within the limits. The newest sample stays, however
/// large it is. If a large sample is given up while it is being sent, half of all kept samples are given up.
/// Otherwise the next large sample would be given up in the same way, and no large sample would ever arrive
/// whole.
void KeptSamples::make_room(Kept& kept, std::size_t added) {
  const std::size_t of_memory = bytes_max_of_memory(added);
  bool cut_short = false;
  while (size() > 1 && must_give_up(of_memory, cut_short)) {
    const Entry& oldest = entries_[begin()];
    cut_short = cut_short || (oldest.state == State::under_way && oldest.size() == Size::large);
    if (oldest.begun) {
      ++kept.unacknowledged;
    } else {
      ++kept.dropped;
      kept.dropped_bytes += oldest.first.total;
      kept.dropped_whole_bytes += oldest.job->whole_bytes_of(oldest.part);
    }
    release_oldest();
  }
}

void KeptSamples::release_oldest() {
  bytes_ -= entries_[begin()].held_bytes();
  entries_.pop_front();
}

std::uint64_t KeptSamples::first_waiting(Size size) {
  std::uint64_t& ordinal = waiting_[static_cast<std::size_t>(size)];
  ordinal = std::max(ordinal, begin());
  const auto waits = [&](const Entry& entry) {
    return entry.state == State::waiting && entry.size() == size;
  };
  while (ordinal < end() && !waits(entries_[ordinal])) ++ordinal;
  return ordinal;
}

void KeptSamples::start(Entry& entry) {
  entry.state = State::under_way;
  entry.begun = true;
}

std::uint32_t KeptSamples::begin_sending(std::uint64_t ordinal) {
  Entry& entry = entries_[ordinal];
  start(entry);
  const std::uint64_t pack_end = std::min(end(), ordinal + entry.job->samples() - entry.part);
  std::uint32_t samples = 1;
  for (++ordinal; ordinal < pack_end && entries_[ordinal].state == State::waiting; ++ordinal, ++samples)
    start(entries_[ordinal]);
  return samples;
}

void KeptSamples::sent(std::uint64_t ordinal, std::uint32_t samples) {
  for (std::uint64_t end = ordinal + samples; ordinal < end; ++ordinal) {
    if (entries_.contains(ordinal)) entries_[ordinal].state = State::sent;
  }
  sent_ = sent_end();
}

std::optional<bool> KeptSamples::departed(std::uint64_t ordinal) {
  if (!entries_.contains(ordinal) || !entries_[ordinal].elsewhere) return std::nullopt;
  const bool first_time = entries_[ordinal].state == State::under_way;
  sent(ordinal, 1);
  return first_time;
}

void KeptSamples::put_back(std::uint64_t ordinal, std::uint32_t samples, std::uint32_t sent_bytes) {
  for (std::uint64_t end = ordinal + samples; ordinal < end; ++ordinal) {
    if (!entries_.contains(ordinal)) continue;
    Entry& entry = entries_[ordinal];
    entry.state = State::waiting;
    entry.sent_bytes = sent_bytes;
    std::uint64_t& waiting = waiting_[static_cast<std::size_t>(entry.size())];
    waiting = std::min(waiting, ordinal);
  }
}

std::uint64_t KeptSamples::sent_end() const {
  std::uint64_t ordinal = std::max(sent_, begin());
  while (ordinal < end() && entries_[ordinal].state == State::sent) ++ordinal;
  return ordinal;
}

void KeptSamples::release_before(std::uint64_t next) {
  while (!entries_.empty() && begin() < next && entries_[begin()].begun) release_oldest();
}

}  // namespace sft::udp
