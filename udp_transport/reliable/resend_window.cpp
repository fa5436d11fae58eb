#include "udp_transport/reliable/resend_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

ResendWindow::ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
                           std::uint64_t first_ordinal, std::shared_ptr<const KeptMemory> memory)
    : writer_(writer),
      channel_(channel),
      kept_(limits, first_ordinal, std::move(memory)),
      repairs_(limits.repair_bytes_per_s),
      heartbeats_(limits) {}

ResendWindow::Kept ResendWindow::keep(JobHandle job, FirstHeader first, bool elsewhere) {
  first.flags |= channel_follows;
  first.channel = {.channel = channel_,
                   .sequence_high = static_cast<std::uint32_t>(job->sequence >> 32),
                   .ordinal = kept_.end()};
  const Kept kept = kept_.keep(job, first, elsewhere);
  repairs_.drop_before(kept_.begin());
  return kept;
}

JobHandle ResendWindow::sent_elsewhere(std::uint64_t ordinal) const {
  if (!kept_.contains(ordinal)) return {};
  const KeptSamples::Entry& entry = kept_[ordinal];
  return entry.elsewhere && entry.state == KeptSamples::State::sent ? entry.job : JobHandle{};
}

void ResendWindow::departed(std::uint64_t ordinal, Time now) {
  if (const std::optional<bool> first_time = kept_.departed(ordinal))
    heartbeats_.sent(*first_time, kept_.amount(), now);
}

std::optional<std::uint32_t> ResendWindow::bytes_sent(std::uint64_t ordinal) const {
  if (!kept_.contains(ordinal) || !kept_[ordinal].begun) return std::nullopt;
  return kept_[ordinal].first.total;
}

bool ResendWindow::has_work() {
  return !repairs_.empty() || kept_.first_waiting(Size::small) != kept_.end() ||
         kept_.first_waiting(Size::large) != kept_.end();
}

/// Returns a repair or a sample. Repairs and samples take turns, so that neither blocks the other.
std::optional<ResendWindow::Piece> ResendWindow::next(Size size, Time now) {
  const bool repair_first = !std::exchange(repair_was_last_, false);
  std::optional<Piece> piece = repair_first ? next_repair(size, now) : next_sample(size);
  if (!piece) piece = repair_first ? next_sample(size) : next_repair(size, now);
  repair_was_last_ = piece && piece->is_repair;
  return piece;
}

ResendWindow::Piece ResendWindow::piece_of(std::uint64_t ordinal) const {
  const KeptSamples::Entry& entry = kept_[ordinal];
  Piece piece{.first = entry.first, .job = entry.job, .ordinal = ordinal, .part = entry.part};
  piece.first.channel.in_short = heard_;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_repair(Size size, Time now) {
  const auto repair = repairs_.next(size, now);
  if (!repair) return {};
  Piece piece = piece_of(repair->ordinal);
  piece.range = repair->range;
  piece.is_repair = true;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_sample(Size size) {
  const std::uint64_t ordinal = kept_.first_waiting(size);
  if (ordinal == kept_.end()) return {};
  return begin_sample(ordinal);
}

std::optional<ResendWindow::Piece> ResendWindow::take(std::uint64_t ordinal) {
  if (kept_.first_waiting(kept_[ordinal].size()) != ordinal) return {};
  return begin_sample(ordinal);
}

ResendWindow::Piece ResendWindow::begin_sample(std::uint64_t ordinal) {
  Piece piece = piece_of(ordinal);
  piece.range.begin = kept_[ordinal].sent_bytes;
  piece.samples = kept_.begin_sending(ordinal);
  return piece;
}

void ResendWindow::finished(const Piece& piece, Time now) {
  if (!piece.is_repair) kept_.sent(piece.ordinal, piece.samples);
  heartbeats_.sent(!piece.is_repair, kept_.amount(), now);
}

void ResendWindow::put_back(const Piece& piece) {
  if (!piece.is_repair) kept_.put_back(piece.ordinal, piece.samples, piece.range.begin);
}

void ResendWindow::hear(const Ack& ack, Time now, Time::duration round_trip) {
  if (ack.writer != writer_) return;
  if (ack.channel != channel_) {
    heard_ = false;
    heartbeats_.want_soon(kept_.amount(), now);
    return;
  }
  if (ack.next > kept_.end()) {
    ++impossible_;
    return;
  }
  impossible_ = 0;
  heard_ = true;
  repairs_.forget_sent_before(now - round_trip);
  kept_.release_before(ack.next);
  repairs_.drop_before(kept_.begin());
  for (const Missing& part : ack.parts()) ask_for(part, ack.next, now);
  heartbeats_.answered(kept_.amount(), now);
}

/// Handles a request for a part of a sample. A request for a sample that is still being sent for the first
/// time is ignored. If the sample is not kept any more, or was never published, a heartbeat names the
/// samples that are kept.
void ResendWindow::ask_for(const Missing& part, std::uint64_t next, Time now) {
  const std::uint64_t ordinal = widen_sequence(next, part.ordinal);
  if (!kept_.contains(ordinal)) return heartbeats_.want();
  if (kept_[ordinal].state != KeptSamples::State::sent) return;
  heartbeats_.lost(now);
  repairs_.ask_for({ordinal, {part.begin, std::min(part.end, kept_[ordinal].first.total)}});
}

std::optional<Heartbeat> ResendWindow::heartbeat(Time now) {
  if (!heartbeats_.take(kept_.amount(), now)) return {};
  // The receiver may assign samples to a wrong channel, so from now on they carry the full number of this
  // channel.
  if (heartbeats_.unanswered() > 1) heard_ = false;
  const std::uint64_t end = kept_.sent_end();
  return Heartbeat{.writer = writer_,
                   .channel = channel_,
                   .first = kept_.begin(),
                   .end = end,
                   .waiting = static_cast<std::uint32_t>(kept_.end() - end)};
}

Heartbeat ResendWindow::parting() const {
  return {.writer = writer_, .channel = channel_, .first = kept_.end(), .end = kept_.end()};
}

ResendWindow::Time ResendWindow::next_look(Time now) const {
  return std::min(heartbeats_.next(), repairs_.next_ready(now));
}

}  // namespace sft::udp
