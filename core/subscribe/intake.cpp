#include "core/subscribe/intake.h"

#include <algorithm>
#include <array>

#include "core/seam/gate_table.h"

namespace sft::core {

namespace {

constexpr std::array all_inlets{Intake::Inlet::memory, Intake::Inlet::network, Intake::Inlet::overtaken,
                                Intake::Inlet::vanilla};

/// Returns true if `next` is newer than `latest`. If both are of one writer, the later sample is always
/// newer, even if the writer's clock was set back.
bool is_newer(const SampleInfo& next, const SampleInfo& latest) {
  return next.writer == latest.writer || next.source_stamp > latest.source_stamp;
}

TransportKind transport_of(Intake::Inlet inlet) {
  if (inlet == Intake::Inlet::vanilla) return TransportKind::dds;
  return inlet == Intake::Inlet::network ? TransportKind::udp : TransportKind::shm;
}

}  // namespace

bool Intake::has_of(Inlet inlet, EndpointId writer) const {
  return !is_empty(inlet) && head(inlet)->writer == writer;
}

/// Puts a sample into an inlet. The gate table of a sample in shared memory shows which of this subscriber's
/// gates the sample has passed.
void Intake::put(Inlet inlet, SampleHandle sample) {
  head(inlet) = std::move(sample);
  if (inlet == Inlet::network || inlet == Inlet::vanilla || is_empty(inlet)) return;
  SampleBuffer& buffer = *head(inlet);
  for (const std::uint64_t gate : accounts_.asked_gates().nameable()) {
    const std::optional<std::uint32_t> ordinal = ordinal_in_gate(buffer, options_.slots, gate);
    if (!ordinal) continue;
    // If the sample has passed several of these gates, it is unknown which of them was in force.
    buffer.ordinal = buffer.gate == 0 ? *ordinal : 0;
    if (buffer.gate == 0) buffer.gate = gate;
  }
}

/// Returns the side that applies the maximum rate to the sample in the inlet. By UDP a writer sends only
/// samples that are for this subscriber, so the writer applies the rate. The writer also applies it in shared
/// memory for samples that name a gate with conditions. VanillaInlet applies it for unmodified DDS writers.
RateKeeper Intake::rate_keeper_of(Inlet inlet) const {
  const bool by_writer = inlet == Inlet::network || inlet == Inlet::vanilla || head(inlet)->gate != 0;
  return by_writer ? RateKeeper::writer : RateKeeper::reader;
}

/// Returns true if no sample of the same writer goes before the sample in the inlet, or has to wait.
bool Intake::may_go_first(Inlet inlet) const {
  if (is_empty(inlet)) return false;
  const SampleOrigin& sample = *head(inlet);
  return std::ranges::none_of(all_inlets, [&](Inlet other) {
    return has_of(other, sample.writer) &&
           (waits_[static_cast<std::size_t>(other)] || head(other)->sequence < sample.sequence);
  });
}

/// Returns the inlet whose sample is to be delivered next: the oldest one, unless that of another writer has
/// been passed over too often.
std::optional<Intake::Inlet> Intake::first_in_turn() const {
  const auto passed_over = [this](Inlet inlet) { return passed_over_[static_cast<std::size_t>(inlet)]; };
  std::optional<Inlet> oldest, due;
  for (const Inlet inlet : all_inlets) {
    if (may_go_first(inlet) && (!oldest || goes_first(*head(inlet), *head(*oldest)))) oldest = inlet;
  }
  if (!oldest) return {};
  for (const Inlet inlet : all_inlets) {
    if (passed_over(inlet) < std::max(passed_over_max, due ? passed_over(*due) : 0)) continue;
    if (may_go_first(inlet) && !has_of(*oldest, head(inlet)->writer)) due = inlet;
  }
  return due ? due : oldest;
}

Intake::Decision Intake::next(LazyRealtime& now) {
  waits_ = {};
  return decide_in_turn(now);
}

/// Decides about the sample whose turn it is, of the writers whose samples do not wait.
Intake::Decision Intake::decide_in_turn(LazyRealtime& now) {
  const std::optional<Inlet> first = first_in_turn();
  if (!first) return Decision::nothing;
  chosen_ = *first;
  if (chosen_ == Inlet::vanilla || accounts_.follows(*head(chosen_))) return choose(chosen_, now);
  if (chosen_ == Inlet::network) return let_overtaken_go_first(now);
  if (!may_wait(now)) return choose(chosen_, now);
  asked_about_ = head(chosen_)->writer;
  return Decision::ask_connected;
}

/// Returns true if, according to the samples, an earlier sample was sent by UDP and may still arrive. That
/// sample cannot arrive any more once a later one has arrived by UDP. It also cannot arrive if it was
/// published before the subscriber was connected to the writer. Both stamps are by this host's clock; if the
/// clock was set meanwhile, there is no wait.
bool Intake::may_wait(LazyRealtime& now) {
  const SampleBuffer& buffer = *head(chosen_);
  const SampleOrigin diverted{.sequence = buffer.diverted_sequence,
                              .source_stamp_ns = buffer.diverted_stamp_ns};
  const Writer& from = accounts_.of(buffer.writer);
  const bool was_diverted = diverted.sequence < buffer.sequence &&
                            diverted.source_stamp_ns >= from.since_ns && from.sequences.is_new(diverted) &&
                            from.sequences.allows(diverted, rate_keeper_of(chosen_));
  // Samples that were sent by UDP only because of this subscriber are not named as diverted, since the writer
  // served other subscribers in shared memory all the time. Only the path of the last sample shows that there
  // may be such samples.
  if (!was_diverted && !from.last_over_network) return false;
  const std::int64_t age_ns = now.ns() - (was_diverted ? diverted.source_stamp_ns : buffer.source_stamp_ns);
  if (age_ns < 0 || age_ns >= options_.timeout.count()) return false;
  return !has_of(Inlet::network, buffer.writer);
}

Intake::Decision Intake::connected(bool is_connected, LazyRealtime& now) {
  if (!is_connected) return choose(chosen_, now);
  holds_back_ = true;
  waits_[static_cast<std::size_t>(chosen_)] = true;
  return decide_in_turn(now);
}

/// Chooses the sample that came by UDP, or an earlier one of its writer that lies in shared memory behind
/// samples of other writers.
Intake::Decision Intake::let_overtaken_go_first(LazyRealtime& now) {
  const SampleBuffer& ahead = *head(Inlet::network);
  if (!accounts_.follows(ahead) && is_empty(Inlet::overtaken) && !has_of(Inlet::memory, ahead.writer)) {
    asked_about_ = ahead.writer;
    return Decision::ask_overtaken;
  }
  return choose_in_turn(now);
}

Intake::Decision Intake::overtaken(SampleHandle found, LazyRealtime& now) {
  put(Inlet::overtaken, std::move(found));
  return choose_in_turn(now);
}

Intake::Decision Intake::choose_in_turn(LazyRealtime& now) {
  const SampleBuffer& ahead = *head(Inlet::network);
  const bool is_earlier =
      has_of(Inlet::overtaken, ahead.writer) && head(Inlet::overtaken)->sequence < ahead.sequence;
  return choose(is_earlier ? Inlet::overtaken : Inlet::network, now);
}

/// Delivers the sample of that inlet, which is the next one, or drops it if it is not for the subscriber.
Intake::Decision Intake::choose(Inlet inlet, LazyRealtime& now) {
  chosen_ = inlet;
  const SampleOrigin& sample = *head(inlet);
  const RateKeeper keeper = rate_keeper_of(inlet);
  Writer& from = accounts_.of(sample.writer);
  if (inlet == Inlet::vanilla) from.sequences.note_restart(sample);
  // False if the sample arrived by both paths during the switch from one to the other.
  const bool is_new = from.sequences.is_new(sample);
  const bool is_allowed = is_new && from.sequences.allows(sample, keeper);
  const bool expired = is_allowed && is_expired(from, sample, now);
  if (is_allowed && !expired) return Decision::deliver;
  is_new ? accounts_.enter(from, sample, keeper) : from.sequences.refuse(sample);
  if (expired) ++from.expired;
  head(inlet).reset();
  passed_over_[static_cast<std::size_t>(inlet)] = 0;
  return Decision::dropped;
}

bool Intake::is_expired(const Writer& from, const SampleOrigin& sample, LazyRealtime& now) {
  return from.lifespan_ns != 0 && is_older(sample.source_stamp_ns, from.lifespan_ns, now.ns());
}

Taken Intake::take() {
  const TransportKind transport = transport_of(chosen_);
  SampleHandle& next = head(chosen_);
  const SampleOrigin& sample = *next;
  Writer& from = accounts_.of(sample.writer);
  accounts_.enter(from, sample, rate_keeper_of(chosen_));
  using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;
  const SampleInfo info{.sequence = sample.sequence,
                        .writer = from.id,
                        .source_stamp = Stamp(std::chrono::nanoseconds(sample.source_stamp_ns)),
                        .receive_stamp = Stamp(std::chrono::nanoseconds(next->receive_stamp_ns)),
                        .lost_before = std::exchange(from.lost_untold, 0),
                        .transport = transport};
  if (!is_copied(transport)) ++from.received;
  Taken taken{std::move(next), info};
  for (std::size_t i = 0; i < heads_.size(); ++i) passed_over_[i] = heads_[i] ? passed_over_[i] + 1 : 0;
  return taken;
}

void Intake::copied(const SampleInfo& info, bool is_delivered) {
  is_delivered ? static_cast<void>(++accounts_.of(info.writer).received)
               : accounts_.lose_entered(info.writer, info.lost_before);
}

void Intake::keep_newer(Taken& latest, Taken other) {
  if (is_newer(other.info, latest.info)) std::swap(latest, other);
  Writer& from = accounts_.of(other.info.writer);
  if (is_copied(other.info.transport)) ++from.received;
  // The next delivered sample of that writer reports these losses.
  from.lost_untold += other.info.lost_before;
}

void Intake::report_losses(Taken& latest) {
  latest.info.lost_before += std::exchange(accounts_.of(latest.info.writer).lost_untold, 0);
}

}  // namespace sft::core
