#include "udp_transport/reliable/resend_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::size_t repairs_max = 512;  // waiting; what is asked for beyond is asked for again
constexpr std::size_t repair_burst_bytes = std::size_t{1} << 20;
}  // namespace

ResendWindow::ResendWindow(std::uint32_t writer, std::uint32_t channel, const ResendLimits& limits,
                           std::uint64_t first_ordinal, std::shared_ptr<const KeptMemory> memory)
    : writer_(writer),
      channel_(channel),
      limits_(limits),
      memory_(std::move(memory)),
      kept_(first_ordinal),
      waiting_{first_ordinal, first_ordinal},
      sent_(first_ordinal),
      repair_pacer_(limits.repair_bytes_per_s, repair_burst_bytes) {
  repairs_.reserve(repairs_max);
}

ResendWindow::Kept ResendWindow::keep(JobHandle job, FirstHeader first, bool elsewhere) {
  Kept kept{.ordinal = kept_.end()};
  first.flags |= channel_follows;
  first.channel = {.channel = channel_,
                   .sequence_high = static_cast<std::uint32_t>(job->sequence >> 32),
                   .ordinal = kept.ordinal};
  const std::size_t before = kept_bytes_;
  push(job, first);
  make_room(kept, kept_bytes_ - before);
  kept.ordinal = std::max(kept.ordinal, kept_.begin());
  kept.elsewhere = elsewhere && !keeps_more_than(limits_.samples / 2, limits_.bytes / 2);
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

void ResendWindow::departed(std::uint64_t ordinal, Time now) {
  if (!kept_.contains(ordinal) || !kept_[ordinal].elsewhere) return;
  const bool first_time = std::exchange(kept_[ordinal].state, State::sent) == State::under_way;
  if (first_time && sent_at_ != Time{}) learn_pause(now - sent_at_);
  sent_at_ = now;
  sent_ = sent_end();
  if (unanswered_ == 0) plan_heartbeat(now);
}

bool ResendWindow::keeps_more_than(std::size_t samples, std::size_t bytes) const {
  return kept_.size() > samples || kept_bytes_ > bytes;
}

bool ResendWindow::can_keep(std::size_t samples, std::size_t bytes) const {
  if (kept_.empty()) return true;
  samples += kept_.size();
  const std::size_t in_all = kept_bytes_ + bytes;
  return samples <= limits_.samples && in_all <= limits_.bytes &&
         (memory_ == nullptr || !memory_->wants_some_of(in_all, bytes));
}

/// Returns the limit if so much more is added. If all channels together keep too much, twice as much has to
/// go, as long as necessary.
std::size_t ResendWindow::bytes_max(std::size_t added) const {
  if (memory_ == nullptr || !memory_->wants_some_of(kept_bytes_)) return limits_.bytes;
  return std::min(limits_.bytes, std::max(added, kept_bytes_ - std::min(kept_bytes_, 2 * added)));
}

/// The newest stays, however large it is. Where a large one is cut short by that, more goes: else the next
/// one would be cut short as well, and nothing would ever come whole.
void ResendWindow::make_room(Kept& kept, std::size_t added) {
  const std::size_t bytes_max = this->bytes_max(added);
  bool cut_short = false;
  while (kept_.size() > 1 && (keeps_more_than(limits_.samples, bytes_max) ||
                              (cut_short && keeps_more_than(limits_.samples / 2, bytes_max / 2)))) {
    const Entry& oldest = kept_[kept_.begin()];
    cut_short = cut_short || (oldest.state == State::under_way && size_of(oldest.first.total) == Size::large);
    if (oldest.begun) {
      ++kept.unacknowledged;
    } else {
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
  kept_bytes_ -= oldest.held_bytes();
  std::erase_if(repairs_, [&](const Repair& repair) { return repair.ordinal == ordinal; });
  kept_.pop_front();
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
  repair_is_paced_ = false;
  const bool repair_first = !std::exchange(repair_was_last_, false);
  std::optional<Piece> piece = repair_first ? next_repair(size, now) : next_sample(size);
  if (!piece) piece = repair_first ? next_sample(size) : next_repair(size, now);
  repair_was_last_ = piece && piece->is_repair;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_repair(Size size, Time now) {
  const auto repair = std::find_if(repairs_.begin(), repairs_.end(),
                                   [&](const Repair& candidate) { return candidate.size == size; });
  if (repair == repairs_.end()) return {};
  repair_is_paced_ = !repair_pacer_.ready(now);
  if (repair_is_paced_) return {};
  const Entry& entry = kept_[repair->ordinal];
  Piece piece{entry.first, entry.job, repair->range, repair->ordinal, true, entry.part};
  piece.first.channel.in_short = heard_;
  repair_pacer_.spend(std::max<std::size_t>(repair->range.end - repair->range.begin, datagram_bytes_min));
  if (repaired_lately_.size() == repairs_max) repaired_lately_.pop_front();
  repaired_lately_.push_back({repair->ordinal, repair->range, now});
  repairs_.erase(repair);
  ++repaired_;
  return piece;
}

std::optional<ResendWindow::Piece> ResendWindow::next_sample(Size size) {
  const std::uint64_t ordinal = first_waiting(size);
  if (ordinal == kept_.end()) return {};
  return begin(ordinal);
}

std::optional<ResendWindow::Piece> ResendWindow::take(std::uint64_t ordinal) {
  const Size size = size_of(kept_[ordinal].first.total);
  if (first_waiting(size) != ordinal) return {};
  return begin(ordinal);
}

void ResendWindow::start(Entry& entry) {
  entry.state = State::under_way;
  entry.begun = true;
}

ResendWindow::Piece ResendWindow::begin(std::uint64_t ordinal) {
  Entry& entry = kept_[ordinal];
  start(entry);
  Piece piece{entry.first, entry.job, {.begin = entry.sent_bytes}, ordinal, false, entry.part};
  piece.first.channel.in_short = heard_;
  const std::uint64_t end = std::min(kept_.end(), ordinal + entry.job->samples() - entry.part);
  for (++ordinal; ordinal < end; ++ordinal, ++piece.samples) {
    if (kept_[ordinal].state != State::waiting) break;
    start(kept_[ordinal]);
  }
  return piece;
}

void ResendWindow::finished(const Piece& piece, Time now) {
  if (!piece.is_repair && sent_at_ != Time{}) learn_pause(now - sent_at_);
  sent_at_ = now;
  for (std::uint32_t i = 0; !piece.is_repair && i < piece.samples; ++i) {
    if (kept_.contains(piece.ordinal + i)) kept_[piece.ordinal + i].state = State::sent;
  }
  sent_ = sent_end();
  if (unanswered_ == 0) plan_heartbeat(now);
}

/// One that is much longer, as behind a burst, hardly counts. Of two threads that send at the same time one
/// may have begun before the other and be noted behind it.
void ResendWindow::learn_pause(Time::duration pause) {
  pause = std::max(pause, Time::duration{});
  if (usual_pause_ == Time::duration{}) {
    usual_pause_ = pause;
  } else if (pause > usual_pause_) {
    usual_pause_ += std::min(pause - usual_pause_, usual_pause_) / 8;
  } else {
    usual_pause_ -= (usual_pause_ - pause) / 4;
  }
}

void ResendWindow::put_back(const Piece& piece) {
  for (std::uint64_t ordinal = piece.ordinal; ordinal < piece.ordinal + piece.samples; ++ordinal) {
    if (piece.is_repair || !kept_.contains(ordinal)) continue;
    Entry& entry = kept_[ordinal];
    entry.state = State::waiting;
    entry.sent_bytes = piece.range.begin;
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

void ResendWindow::hear(const Ack& ack, Time now, Time::duration round_trip) {
  if (ack.writer != writer_) return;
  if (ack.channel != channel_) return name_channel_in_full(now);
  if (ack.next > kept_.end()) {
    ++impossible_;
    return;
  }
  impossible_ = 0;
  heard_ = true;
  while (!repaired_lately_.empty() && now - repaired_lately_.front().at >= round_trip)
    repaired_lately_.pop_front();
  release_before(ack.next);
  for (const Missing& part : ack.parts()) ask_for(part, ack.next, now);
  unanswered_ = 0;
  plan_heartbeat(now);
}

void ResendWindow::name_channel_in_full(Time now) {
  heard_ = false;
  answer_wanted_ = true;
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
    return known.ordinal == ordinal && overlap(known.range, range);
  });
  if (!asked && !is_repaired_just_now(ordinal, range))
    repairs_.push_back({ordinal, range, size_of(range.end - range.begin)});
}

bool ResendWindow::is_repaired_just_now(std::uint64_t ordinal, const BodyRange& range) const {
  return std::ranges::any_of(repaired_lately_, [&](const Repaired& repaired) {
    return repaired.ordinal == ordinal && overlap(repaired.range, range);
  });
}

/// A loss is noticed with the sample after it; so what matters is that no other one comes. That is asked for
/// as often as there are heartbeats to spare.
ResendWindow::Time ResendWindow::end_of_usual_pause() const {
  const Time affordable = heartbeats_paid_until_ - limits_.heartbeats_saved * limits_.heartbeat_pause;
  return std::max(sent_at_ + 2 * usual_pause_, affordable);
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
  } else if (keeps_more_than(limits_.samples / 2, limits_.bytes / 2)) {
    heartbeat_at_ = std::max(now, heartbeat_sent_at_ + limits_.heartbeat_pause);
  } else {
    const bool bad_link = lost_at_ && now - *lost_at_ < limits_.mistrust;
    const Time usual = heartbeat_sent_at_ + (bad_link ? limits_.heartbeat_delay : limits_.heartbeat_period);
    heartbeat_at_ = std::max(sent_at_ + limits_.heartbeat_delay, std::min(usual, end_of_usual_pause()));
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
  heartbeats_paid_until_ = std::max(heartbeats_paid_until_, now) + limits_.heartbeat_pause;
  const auto doubled = limits_.heartbeat_delay * (1 << std::min(++unanswered_, 10));
  if (unanswered_ > 1) heard_ = false;  // it may have taken another channel for ours: samples name it in full
  heartbeat_at_ = now + std::min<Time::duration>(doubled, limits_.heartbeat_longest);
  const std::uint64_t end = sent_end();
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
  Time look = heartbeat_at_;
  if (repair_is_paced_) look = std::min(look, repair_pacer_.next_ready(now));
  return look;
}

}  // namespace sft::udp
