#include "udp_transport/receive/incoming_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sft/detail/walk.h"

namespace sft::udp {

namespace {

using Standing = ArrivalWindow::Standing;

/// The maximum number of missing parts that are requested at a time; further parts are requested later.
constexpr std::size_t asked_at_once_max = 8 * missing_max;

/// Calls `ask(Missing)` for each part of a sample that has not come. `sample` is null if no part of it has
/// come.
template <class Ask>
void for_each_missing(std::uint32_t ordinal, const UnfinishedSample* sample, const Ask& ask) {
  if (sample == nullptr) return ask(Missing{ordinal, 0, 0});
  std::uint32_t at = 0;
  for (const IntervalSet::Interval& had : sample->received().intervals()) {
    if (had.begin > at) ask(Missing{ordinal, at, had.begin});
    at = had.end;
  }
  if (at < sample->first().total) ask(Missing{ordinal, at, sample->first().total});
}

bool has(const Datagram& d, std::uint8_t flag) { return (d.first.flags & flag) != 0; }

std::uint64_t sequence_of(const FirstHeader& first, const SequenceMonitor& sequences) {
  const auto with = [&](std::uint32_t high) { return std::uint64_t{high} << 32 | first.label.sequence; };
  if ((first.flags & channel_follows) != 0) return with(first.channel.sequence_high);
  if ((first.flags & group_follows) != 0) return with(first.group.sequence_high);
  return sequences.widen(first.label.sequence);
}

/// Returns true if an earlier sample may still be in the socket for groups. A writer can stop using a group
/// after any sample, so this is possible whenever samples of a group have come.
bool may_overtake(std::uint64_t sequence, const FirstHeader& first, const SequenceMonitor& sequences,
                  const OfferedGroups& groups) {
  if (sequences.newest() == 0 || sequence <= sequences.newest() + 1) [[likely]]
    return false;
  return (first.flags & group_follows) == 0 && groups.were_heard();
}

/// Gives up a sample with another label that has begun at that place, if it makes no progress. It may be
/// forged. Returns true if it was given up.
bool gives_way(ArrivedSamples& arrived, const SampleAssembly& samples, std::uint64_t place,
               const SampleLabel& label, IncomingWriter::Time now) {
  constexpr std::chrono::milliseconds progress_holds{20};
  using State = ArrivedSamples::State;
  if (!arrived.slots().contains(place) || arrived.slots()[place].state != State::begun) return false;
  const SampleLabel label_there = arrived.slots()[place].label;
  if (label_there == label) return false;
  const UnfinishedSample* const sample = samples.find(label_there);
  if (sample != nullptr && now - sample->last_progress() < progress_holds) return false;
  arrived.give_back(place, now);
  return true;
}

/// Writes all fields of the header, except the writer and the sequence.
void write_header(core::SampleBuffer& sample, const FirstHeader& first, const TypeSupport& type) {
  detail::SampleHeader& header = sample.header();
  header.index_slots = static_cast<std::uint16_t>(type.index_slots());
  header.source_stamp_ns = first.stamp_ns;
  header.type_hash = type.hash();
  header.body_offset = static_cast<std::uint32_t>(detail::SampleLayout(type.index_slots()).body_offset);
  header.body_bytes = first.total;
  sample.trust_header();
}

/// Builds the index of the fields in the body. Returns false if the body is not valid for the type.
bool index_body(core::SampleBuffer& sample, const TypeSupport& type) {
  std::byte* body = sample.data + sample.header().body_offset;
  std::memcpy(body - detail::encapsulation_bytes, detail::encapsulation_cdr_le.data(),
              detail::encapsulation_bytes);
  detail::SampleState state;
  state.body = body;
  state.body_bytes = sample.header().body_bytes;
  state.mask = &sample.mask;
  return detail::build_index(state, type.type(), {sample.index(), type.index_slots()}) ==
         detail::WalkStatus::ok;
}

}  // namespace

void IncomingWriter::follow(const Stream& stream, std::size_t stream_index) {
  const std::size_t limit = shared_.limits.sample_bytes;
  facts_ = {.id = stream.writer,
            .type = stream.type,
            .stream_index = stream_index,
            .alive = stream.alive,
            .sample_bytes = stream.max_sample_bytes == 0 ? limit : std::min(stream.max_sample_bytes, limit),
            .node = stream.node,
            .came_from = facts_.came_from};
  wanted_.set(*stream.type, stream.selections);
}

void IncomingWriter::open_window(const std::optional<ArrivalWindow::Mark>& departed) {
  window_ = std::make_unique<ArrivalWindow>(shared_.limits.channel);
  if (departed) window_->join(*departed);
}

std::optional<ArrivalWindow::Mark> IncomingWriter::close_window() {
  if (window_ == nullptr) return {};
  samples_.forget_places();
  const auto mark = window_->mark();
  window_.reset();
  answers_.close();
  return mark;
}

bool IncomingWriter::follows(std::uint32_t channel) const {
  const auto mark = window_ == nullptr ? std::nullopt : window_->mark();
  return mark && mark->channel == channel;
}

bool IncomingWriter::fits(const Datagram& d) {
  if (has(d, channel_follows) && follows(d.first.channel.channel)) return true;
  Datagram copy = d;  // a copy, because named_by() removes the mask's words from its argument
  const WantedMasks::Named named = wanted_.named_by(copy);
  return named.mask != nullptr && !named.malformed &&
         std::max<std::size_t>(copy.first.total, copy.bytes_each) <= facts_.sample_bytes;
}

Arrival IncomingWriter::accept(Datagram& d, const Envelope& envelope) {
  answers_.received(envelope.bytes);
  if (has(d, group_follows) && !place_by_group(d, envelope.now.steady)) return {};
  const WantedMasks::Named named = wanted_.named_by(d);
  return d.kind == DatagramKind::packed ? accept_packed(d, named, envelope.now)
                                        : accept_first(d, named, envelope.now);
}

/// Sets the ordinal in the channel of a sample that came by a group. Returns false if the group was not
/// offered to this process, or if the sample is not for its present readers.
bool IncomingWriter::place_by_group(Datagram& d, Time now) {
  const bool is_placed = groups_.place(d.first, now, window_ == nullptr ? nullptr : &window_->channels());
  shared_.group_reports_due = shared_.group_reports_due || groups_.due();
  if (!is_placed) {
    elsewhere_.add(d.label());
  } else if (window_ != nullptr && has(d, channel_follows)) {
    window_->samples().schedule().spread();
  }
  return is_placed;
}

/// Accepts each sample of a pack as if it had come in a separate datagram.
Arrival IncomingWriter::accept_packed(const Datagram& packed, const WantedMasks::Named& named,
                                      ArrivalTime now) {
  PackedBodies bodies(packed);
  if (named.malformed || !bodies.sound()) {
    ++shared_.counters.malformed;
    return {};
  }
  if (packed.bytes_each != 0 && named.mask != nullptr && packed.bytes_each <= facts_.sample_bytes) {
    const std::size_t bytes = detail::SampleLayout(facts_.type->index_slots()).bytes(packed.bytes_each);
    const std::size_t reserved = window_ == nullptr ? 0 : reserved_for_first_missing();
    shared_.pool->take_kept(bytes, shared_.reserved_for_publishers() + reserved, packed.samples,
                            shared_.pack_buffers);
  }
  Arrival arrival{{}, facts_.stream_index};
  Datagram d;
  d.kind = DatagramKind::first;
  for (std::uint32_t i = 0; i < packed.samples; ++i) {
    d.payload = bodies.next();
    d.first = header_behind(packed.first, i, static_cast<std::uint32_t>(d.payload.size()));
    Arrival one = accept_first(d, named, now, i > 0);
    arrival.in_channel |= one.in_channel;
    arrival.may_overtake |= one.may_overtake;
    if (one.sample) shared_.packed.push_back(std::move(one.sample));
  }
  shared_.pack_buffers.clear();
  arrival.packed = shared_.packed;
  return arrival;
}

Arrival IncomingWriter::accept_first(const Datagram& d, const WantedMasks::Named& named, ArrivalTime now,
                                     bool same_datagram) {
  ArrivalWindow::Met met{Standing::wanted, 0};
  if (window_ != nullptr && has(d, channel_follows)) {
    met = window_->meet(d.first.channel, now.steady, same_datagram);
    if (met.standing == Standing::known &&
        gives_way(window_->samples(), samples_, met.place, d.label(), now.steady))
      met = window_->meet(d.first.channel, now.steady, same_datagram);
    if (met.standing == Standing::known && met.place != 0)
      window_->samples().unconfirm(met.place, d.label().sequence);
    drop_abandoned();
  }
  UnfinishedSample* sample = samples_.find(d.label());
  const bool repeated =
      sample != nullptr ? sample->described() : met.place == 0 && samples_.is_finished(d.label());
  const Arrival nothing{{}, facts_.stream_index, met.place != 0};
  const bool is_wanted = met.standing == Standing::wanted;
  if (has(d, group_follows)) {
    const bool is_old = sample != nullptr || samples_.is_finished(d.label());
    if (is_wanted || !is_old) groups_.note(d.first.group.group, !is_wanted);
  }
  // The sample began to arrive before a reader requested reliable delivery.
  if (is_wanted && met.place != 0 && repeated) {
    samples_.set_place(*sample, met.place);
    window_->samples().begun(met.place, sample->label(), sample->buffer());
  }
  if (repeated || !is_wanted) return nothing;

  core::SampleHandle buffer;
  if (const Refusal why = describe(d, named, met.place, buffer); why != Refusal::none)
    return refuse(d, met.place, why, now.steady);
  const bool is_whole = sample == nullptr && d.payload.size() == d.first.total;
  if (!is_whole) return begin(d, sample, met.place, std::move(buffer), now);
  const std::size_t body_offset = detail::SampleLayout(facts_.type->index_slots()).body_offset;
  if (!d.payload.empty()) std::memcpy(buffer->data + body_offset, d.payload.data(), d.payload.size());
  samples_.finish(d.label());
  return complete(std::move(buffer), d.first, met.place, now);
}

/// Begins a sample that has several datagrams, of which `d` is one. Some of the other datagrams may have
/// come before.
Arrival IncomingWriter::begin(const Datagram& d, UnfinishedSample* sample, std::uint64_t place,
                              core::SampleHandle buffer, ArrivalTime now) {
  if (place != 0) window_->samples().begun(place, d.label(), buffer);
  if (sample == nullptr) sample = &samples_.begin(d.label(), place, now.steady);
  samples_.set_place(*sample, place);
  samples_.describe(*sample, d.first, detail::SampleLayout(facts_.type->index_slots()).body_offset,
                    std::move(buffer));
  sample->add(0, d.payload, shared_.limits.gaps, now.steady);
  Arrival arrival = proceed(*sample, samples_.unpark(*sample, now.steady), now);
  // Even if this sample is not whole, reliable readers may get others, since missing ones may count as lost
  // now.
  arrival.in_channel = place != 0;
  return arrival;
}

Arrival IncomingWriter::accept(const Following& d, const Envelope& envelope) {
  const ArrivalTime now = envelope.now;
  answers_.received(envelope.bytes);
  drop_abandoned();  // called here, too, since the window may have dropped samples after readers took others
  UnfinishedSample* sample = samples_.find(d.label);
  if (sample == nullptr) {
    if (samples_.is_finished(d.label) || elsewhere_.contains(d.label)) return {};
    sample = &samples_.begin(d.label, 0, now.steady);
  }
  if (!sample->described()) {
    using Parked = SampleAssembly::Parked;
    const Parked parked = samples_.park(*sample, d, facts_.sample_bytes, now.steady);
    if (parked == Parked::beyond_body) drop(d.label, shared_.counters.malformed);
    if (parked == Parked::over_limit) drop(d.label, shared_.counters.over_limit);
    return {};
  }
  const std::uint32_t had = sample->received().covered();
  const auto added = sample->add(d.offset, d.payload, shared_.limits.gaps, now.steady);
  if (added == UnfinishedSample::Added::beyond_body) {
    ++shared_.counters.malformed;  // the sample itself may be well-formed
    return {};
  }
  const bool again = added == UnfinishedSample::Added::yes && sample->received().covered() == had;
  if (again && sample->place() != 0) window_->samples().came_again(sample->place());
  return proceed(*sample, added, now);
}

/// Continues after a datagram was added to the sample, or was refused. If a datagram of a reliable sample
/// was refused, the sample is kept, because the datagram can come again.
Arrival IncomingWriter::proceed(UnfinishedSample& sample, UnfinishedSample::Added added, ArrivalTime now) {
  using Added = UnfinishedSample::Added;
  const bool in_channel = sample.place() != 0;
  if (added != Added::yes) [[unlikely]] {
    std::uint64_t& counter =
        added == Added::beyond_body ? shared_.counters.malformed : shared_.counters.over_limit;
    if (!in_channel) {
      drop(sample.label(), counter);
      return {{}, facts_.stream_index, false};
    }
    ++counter;
  }
  if (!sample.whole()) return {{}, facts_.stream_index, false};
  const FirstHeader first = sample.first();
  const std::uint64_t place = sample.place();
  UnfinishedSamples::Handle whole = samples_.remove(first.label);
  samples_.finish(first.label);
  Arrival arrival = complete(whole->take_buffer(), first, place, now);
  shared_.recycle(std::move(whole));
  return arrival;
}

Arrival IncomingWriter::complete(core::SampleHandle sample, const FirstHeader& first, std::uint64_t place,
                                 ArrivalTime now) {
  detail::SampleHeader& header = sample->header();
  header.writer = facts_.id;
  header.sequence = sequence_of(first, sequences_);
  write_header(*sample, first, *facts_.type);
  sample->receive_stamp_ns = now.realtime_ns;
  if (!index_body(*sample, *facts_.type) || header.sequence == 0) {
    ++shared_.counters.malformed;
    if (place != 0) window_->refuse_or_pass(place);
    return {{}, facts_.stream_index, place != 0};
  }
  const bool overtakes = may_overtake(header.sequence, first, sequences_, groups_);
  if (!accepts({header.sequence, place, shared_.datagrams, header.source_stamp_ns}, now.steady)) {
    ++shared_.counters.malformed;
    if (place != 0) window_->samples().refuse(place);
    return {{}, facts_.stream_index, place != 0};
  }
  sample->numbering = sequences_.numbering();
  if (place != 0) window_->whole(place, sample);
  drop_abandoned();
  return {std::move(sample), facts_.stream_index, place != 0, {}, overtakes};
}

/// Returns true if a sample may be delivered. If sequences turn out to be wrong, the samples that wait with
/// them have to come again. A writer that is not alive sends no new data, so a sample that is older than its
/// newest one was repeated by another sender.
bool IncomingWriter::accepts(const SequenceMonitor::Observed& observed, Time now) {
  if (!facts_.alive && observed.place == 0 && observed.sequence < sequences_.newest()) return false;
  const std::uint32_t numbering = sequences_.numbering();
  const bool accepted = sequences_.accepts(observed, now);
  const bool begins_anew = sequences_.numbering() != numbering;
  if (window_ != nullptr && begins_anew && sequences_.newest_was_wrong())
    window_->samples().distrust_above(observed.sequence);
  return accepted;
}

/// Checks the values of a first datagram before anything is allocated, and takes memory for the sample.
IncomingWriter::Refusal IncomingWriter::describe(const Datagram& d, const WantedMasks::Named& named,
                                                 std::uint64_t place, core::SampleHandle& buffer) {
  if (named.malformed) return Refusal::malformed;
  if (named.mask == nullptr) return Refusal::unwanted;
  if (d.payload.size() > d.first.total) return Refusal::malformed;
  if (d.first.total > facts_.sample_bytes) return Refusal::over_limit;
  if (shared_.pack_buffers.empty()) {
    buffer = take_buffer(d, place);
  } else {
    buffer = std::move(shared_.pack_buffers.back());
    shared_.pack_buffers.pop_back();
  }
  if (!buffer) return Refusal::over_limit;
  buffer->mask = *named.mask;
  buffer->parts = named.parts;
  buffer->min_period_us = d.first.rate.min_period_us;
  buffer->gate = core::gate_id(named.conditions, d.first.rate.min_period_us);
  buffer->ordinal = d.first.rate.ordinal;
  buffer->addressee = d.first.history.reader;
  buffer->oldest_retained = d.first.history.oldest;
  buffer->merged = has(d, merged_masks);
  return Refusal::none;
}

/// Takes memory for a sample. Samples after the first missing sample must leave enough memory for that
/// sample, because readers get no later sample before it.
core::SampleHandle IncomingWriter::take_buffer(const Datagram& d, std::uint64_t place) {
  const std::size_t total = d.first.total;
  const std::size_t bytes = detail::SampleLayout(facts_.type->index_slots()).bytes(total);
  if (place == 0) return samples_.take_buffer(bytes, d.label(), total, d.payload.size() == total);
  const std::size_t reserved = place == window_->samples().next() ? 0 : reserved_for_first_missing();
  return samples_.take_reliable_buffer(bytes, total, reserved);
}

std::size_t IncomingWriter::reserved_for_first_missing() const {
  return std::min(detail::SampleLayout(facts_.type->index_slots()).bytes(facts_.sample_bytes),
                  shared_.pool->limit_bytes() / 4);
}

/// Refuses a sample. If only memory is missing, a reliable sample is not given up, because it will come
/// again.
Arrival IncomingWriter::refuse(const Datagram& d, std::uint64_t place, Refusal why, Time now) {
  core::Transport::Counters& counters = shared_.counters;
  const Arrival nothing{{}, facts_.stream_index, place != 0};
  const bool lacks_memory = why == Refusal::over_limit && d.first.total <= facts_.sample_bytes;
  if (lacks_memory) shared_.note_refused(now);
  if (place != 0 && lacks_memory) {
    ++counters.over_limit;
    return nothing;
  }
  if (place != 0 && why == Refusal::malformed) {
    ++counters.malformed;
    window_->refuse_or_pass(place);
    return nothing;
  }
  if (place != 0) window_->pass(place);
  drop(d.label(), why == Refusal::malformed  ? counters.malformed
                  : why == Refusal::unwanted ? counters.unknown
                                             : counters.over_limit);
  return nothing;
}

/// Gives up and counts a sample, even if no datagram of it has come. Further datagrams of the sample are
/// ignored.
void IncomingWriter::drop(const SampleLabel& label, std::uint64_t& counter) {
  const std::uint64_t place = samples_.drop(SampleLabel(label), counter);
  if (place != 0 && window_ != nullptr) window_->pass(place);
}

/// Drops the samples that the window has given up, and those that begin anew.
void IncomingWriter::drop_abandoned() {
  if (window_ == nullptr) return;
  if (window_->samples().dropped().empty()) [[likely]]
    return;
  const ArrivedSamples::Dropped dropped = std::exchange(window_->samples().dropped(), {});
  for (const SampleLabel& label : dropped.abandoned) drop(label, shared_.counters.incomplete);
  for (const SampleLabel& label : dropped.given_back) {
    ++shared_.counters.incomplete;
    samples_.give_back(label);
  }
}

Arrival IncomingWriter::accept(const Heartbeat& heartbeat, const SocketAddress& answers_to,
                               const Envelope& envelope) {
  answers_.received(envelope.bytes);
  answers_.turn_to(answers_to);
  window_->hear(heartbeat, envelope.now.steady);
  drop_abandoned();
  return {{}, facts_.stream_index, true};
}

void IncomingWriter::answer(Time now, const SendAck& send) {
  if (window_ == nullptr || !answers_.is_known()) return;
  const auto came_at = [&](const SampleLabel& label) {
    const UnfinishedSample* sample = samples_.find(label);
    return sample == nullptr ? Time{} : sample->last_progress();
  };
  std::vector<ArrivedSamples::Gap> gaps;
  const std::size_t askable = std::min(asked_at_once_max, answers_.parts_covered());
  if (askable > 0 && now >= window_->next_look())
    gaps = window_->samples().due_gaps(now, came_at, askable, shared_.is_short(now));
  drop_abandoned();
  if (gaps.empty() && !window_->ack_due()) return;
  Ack ack = window_->ack(facts_.short_id());
  std::size_t asked = 0;
  const auto ask = [&](const Missing& part) {
    if (++asked > asked_at_once_max || !answers_.covers(ack.bytes() + missing_bytes)) return;
    if (ack.missing_count == missing_max) {
      answers_.send(ack, send);
      ack.missing_count = 0;
    }
    ack.missing[ack.missing_count++] = part;
  };
  for (const ArrivedSamples::Gap& gap : gaps) {
    const UnfinishedSample* sample = gap.label ? samples_.find(*gap.label) : nullptr;
    const std::size_t before = asked;
    for_each_missing(static_cast<std::uint32_t>(window_->ordinal_of(gap.place)), sample, ask);
    window_->samples().asked_for(gap.place, static_cast<std::uint32_t>(asked - before));
  }
  answers_.send(ack, send);
}

}  // namespace sft::udp
