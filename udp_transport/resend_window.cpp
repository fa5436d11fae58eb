#include "udp_transport/resend_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::size_t repairs_max = 512;  // waiting; what is asked for beyond is asked for again
constexpr std::size_t repair_burst_bytes = std::size_t{1} << 20;
}  // namespace

ResendWindow::ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
                           std::uint64_t first_ordinal)
    : writer_(writer),
      channel_(channel),
      limits_(limits),
      kept_(first_ordinal),
      waiting_{first_ordinal, first_ordinal},
      sent_(first_ordinal),
      repair_pacer_(limits.repair_bytes_per_s) {
  repair_pacer_.set_burst(repair_burst_bytes);
  repairs_.reserve(repairs_max);
}

ResendWindow::Kept ResendWindow::keep(JobHandle job, FirstHeader first, bool elsewhere) {
  Kept kept{.ordinal = kept_.end()};
  first.flags |= channel_follows;
  first.channel = {.channel = channel_,
                   .sequence_high = static_cast<std::uint32_t>(job->sequence >> 32),
                   .ordinal = kept.ordinal};
  push(job, first);
  make_room(kept);
  kept.ordinal = std::max(kept.ordinal, kept_.begin());
  kept.elsewhere = elsewhere && has_room_for(kept.ordinal);
  if (kept.elsewhere) {
    kept_[kept.ordinal].elsewhere = true;
    start(kept_[kept.ordinal]);
  }
  return kept;
}

void ResendWindow::push(const JobHandle& job, const FirstHeader& first) {
  const auto samples = static_cast<std::uint32_t>(job->samples());
  for (std::uint32_t part = 0; part < samples; ++part) {
    kept_bytes_ += job->held_bytes(part);
    kept_.push_back({.first = header_behind(first, part, job->body_bytes(part)), .job = job, .part = part});
  }
}

JobHandle ResendWindow::sent_elsewhere(std::uint64_t ordinal) const {
  if (!kept_.contains(ordinal)) return {};
  const Entry& entry = kept_[ordinal];
  return entry.elsewhere && entry.state == State::sent ? entry.job : JobHandle{};
}

void ResendWindow::left(std::uint64_t ordinal, Time now) {
  if (!kept_.contains(ordinal) || !kept_[ordinal].elsewhere) return;
  sent_at_ = now;
  kept_[ordinal].state = State::sent;
  sent_ = sent_end();
  if (unanswered_ == 0) plan_heartbeat(now);
}

/// The newest stays, however large it is.
void ResendWindow::make_room(Kept& kept) {
  while (kept_.size() > limits_.samples || (kept_bytes_ > limits_.bytes && kept_.size() > 1)) {
    if (const Entry& oldest = kept_[kept_.begin()]; !oldest.begun) {
      ++kept.dropped;
      kept.dropped_bytes += oldest.first.total;
      kept.dropped_whole_bytes += oldest.job->whole_bytes;
    }
    release_oldest();
  }
}

void ResendWindow::release_oldest() {
  const std::uint64_t ordinal = kept_.begin();
  const Entry& oldest = kept_[ordinal];
  if (oldest.state != State::waiting) in_flight_bytes_ -= oldest.first.total;
  kept_bytes_ -= oldest.held_bytes();
  std::erase_if(repairs_, [&](const Repair& repair) { return repair.ordinal == ordinal; });
  kept_.pop_front();
}

/// The oldest may always go: all others wait for it. And some more, until a part of the window is under way
/// that is acknowledged unasked.
bool ResendWindow::has_room_for(std::uint64_t ordinal) const {
  const Entry& entry = kept_[ordinal];
  return ordinal == kept_.begin() || in_flight_bytes_ < std::max<std::size_t>(window_bytes_ / 4, 1) ||
         in_flight_bytes_ + entry.first.total <= window_bytes_;
}

std::uint64_t ResendWindow::first_waiting(Size size) {
  std::uint64_t& ordinal = waiting_[static_cast<std::size_t>(size)];
  ordinal = std::max(ordinal, kept_.begin());
  const auto waits = [&](const Entry& entry) {
    return entry.state == State::waiting && size_of(entry.first.total) == size;
  };
  while (ordinal < kept_.end() && !waits(kept_[ordinal])) ++ordinal;
  return ordinal;
}

std::optional<std::uint32_t> ResendWindow::bytes_sent(std::uint64_t ordinal) const {
  if (!kept_.contains(ordinal) || !kept_[ordinal].begun) return std::nullopt;
  return kept_[ordinal].first.total;
}

bool ResendWindow::has_work() {
  return !repairs_.empty() || first_waiting(Size::small) != kept_.end() ||
         first_waiting(Size::large) != kept_.end();
}

/// Repairs and live samples take turns, so that neither starves the other.
std::optional<ResendWindow::Piece> ResendWindow::next(Size size, Time now) {
  const bool repair_first = !std::exchange(repair_was_last_, false);
  std::optional<Piece> piece = repair_first ? next_repair(size, now) : next_sample(size);
  if (!piece) piece = repair_first ? next_sample(size) : next_repair(size, now);
  repair_was_last_ = piece && piece->is_repair;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_repair(Size size, Time now) {
  const auto repair = std::find_if(repairs_.begin(), repairs_.end(),
                                   [&](const Repair& candidate) { return candidate.size == size; });
  if (repair == repairs_.end() || !repair_pacer_.ready(now)) return {};
  const Entry& entry = kept_[repair->ordinal];
  Piece piece{entry.first, entry.job, repair->range, repair->ordinal, true, entry.part};
  repair_pacer_.spend(std::max<std::size_t>(repair->range.end - repair->range.begin, datagram_bytes_min));
  repairs_.erase(repair);
  ++repaired_;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_sample(Size size) {
  const std::uint64_t ordinal = first_waiting(size);
  if (ordinal == kept_.end()) return {};
  if (has_room_for(ordinal)) return begin(ordinal);
  answer_wanted_ = true;
  return {};
}

std::optional<ResendWindow::Piece> ResendWindow::take(std::uint64_t ordinal) {
  const Size size = size_of(kept_[ordinal].first.total);
  if (first_waiting(size) != ordinal || !has_room_for(ordinal)) return {};
  return begin(ordinal);
}

void ResendWindow::start(Entry& entry) {
  entry.state = State::under_way;
  entry.begun = true;
  in_flight_bytes_ += entry.first.total;
}

/// Of a pack as many as may go.
ResendWindow::Piece ResendWindow::begin(std::uint64_t ordinal) {
  Entry& entry = kept_[ordinal];
  start(entry);
  Piece piece{entry.first, entry.job, {}, ordinal, false, entry.part};
  const std::uint64_t end = std::min(kept_.end(), ordinal + entry.job->samples() - entry.part);
  for (++ordinal; ordinal < end; ++ordinal, ++piece.samples) {
    if (kept_[ordinal].state != State::waiting || !has_room_for(ordinal)) break;
    start(kept_[ordinal]);
  }
  return piece;
}

void ResendWindow::finished(const Piece& piece, Time now) {
  sent_at_ = now;
  for (std::uint32_t i = 0; !piece.is_repair && i < piece.samples; ++i) {
    if (kept_.contains(piece.ordinal + i)) kept_[piece.ordinal + i].state = State::sent;
  }
  sent_ = sent_end();
  if (unanswered_ == 0) plan_heartbeat(now);
}

void ResendWindow::put_back(const Piece& piece) {
  for (std::uint64_t ordinal = piece.ordinal; ordinal < piece.ordinal + piece.samples; ++ordinal) {
    if (piece.is_repair || !kept_.contains(ordinal)) continue;
    Entry& entry = kept_[ordinal];
    entry.state = State::waiting;
    in_flight_bytes_ -= entry.first.total;
    std::uint64_t& waiting = waiting_[static_cast<std::size_t>(size_of(entry.first.total))];
    waiting = std::min(waiting, ordinal);
  }
}

/// Each before it was sent, or is gone.
std::uint64_t ResendWindow::sent_end() const {
  std::uint64_t end = std::max(sent_, kept_.begin());
  while (end < kept_.end() && kept_[end].state == State::sent) ++end;
  return end;
}

/// The other end can have what has left. It may have given up on more than that.
void ResendWindow::release_before(std::uint64_t next) {
  while (!kept_.empty() && kept_.begin() < next && kept_[kept_.begin()].begun) release_oldest();
}

void ResendWindow::hear(const Ack& ack, Time now) {
  if (ack.channel != channel_ || ack.writer != writer_) return;
  if (ack.next > kept_.end()) return;
  window_bytes_ = ack.window_bytes;
  release_before(ack.next);
  for (const Missing& part : ack.parts()) ask_for(part, ack.next, now);
  unanswered_ = 0;
  plan_heartbeat(now);
}

/// A part that is asked for. What is under way for the first time comes anyway, and what has been asked for
/// already is not sent twice.
void ResendWindow::ask_for(const Missing& part, std::uint64_t next, Time now) {
  const std::uint64_t ordinal = widen_sequence(next, part.ordinal);
  if (ordinal < kept_.begin()) answer_wanted_ = true;  // it is gone
  if (!kept_.contains(ordinal) || kept_[ordinal].state != State::sent) return;
  lost_at_ = now;
  const std::uint32_t total = kept_[ordinal].first.total;
  const BodyRange range{part.begin, std::min(part.end, total)};
  if (range.begin > range.end || repairs_.size() >= repairs_max) return;
  if (range.begin != 0 && range.begin == range.end) return;
  const bool asked = std::any_of(repairs_.begin(), repairs_.end(), [&](const Repair& known) {
    if (known.ordinal != ordinal) return false;
    return known.range == range || (known.range.begin < range.end && range.begin < known.range.end);
  });
  if (!asked) repairs_.push_back({ordinal, range, size_of(range.end - range.begin)});
}

/// Soon after the last sample, but seldom while nothing gets lost. Whoever does not answer is asked ever more
/// seldom.
void ResendWindow::plan_heartbeat(Time now) {
  if (kept_.empty()) {
    heartbeat_at_ = Time::max();
  } else if (heartbeat_sent_at_ == Time{}) {
    heartbeat_at_ = now;  // it names the port for acks
  } else if (answer_wanted_) {
    heartbeat_at_ = std::min(heartbeat_at_, std::max(now, heartbeat_sent_at_ + limits_.heartbeat_delay));
  } else {
    const bool bad_link = lost_at_ && now - *lost_at_ < limits_.mistrust;
    const auto pause = bad_link ? limits_.heartbeat_delay : limits_.heartbeat_pause;
    heartbeat_at_ = std::max(sent_at_ + limits_.heartbeat_delay, heartbeat_sent_at_ + pause);
  }
}

void ResendWindow::way_changed(Time now) {
  if (kept_.empty()) return;
  unanswered_ = 0;
  heartbeat_at_ = now;
}

std::optional<Heartbeat> ResendWindow::heartbeat(Time now) {
  if (answer_wanted_ && unanswered_ == 0) plan_heartbeat(now);
  if (now < heartbeat_at_) return {};
  answer_wanted_ = false;
  heartbeat_sent_at_ = now;
  const auto doubled = limits_.heartbeat_delay * (1 << std::min(++unanswered_, 10));
  heartbeat_at_ = now + std::min<Time::duration>(doubled, limits_.heartbeat_longest);
  return Heartbeat{.writer = writer_, .channel = channel_, .first = kept_.begin(), .end = sent_end()};
}

Heartbeat ResendWindow::parting() const {
  return {.writer = writer_, .channel = channel_, .first = kept_.end(), .end = kept_.end()};
}

ResendWindow::Time ResendWindow::next_look(Time now) const {
  Time look = heartbeat_at_;
  if (!repairs_.empty()) look = std::min(look, repair_pacer_.next_ready(now));
  return look;
}

}  // namespace sft::udp
