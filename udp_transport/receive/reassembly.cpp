#include "udp_transport/receive/reassembly.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sft/detail/walk.h"
#include "udp_transport/io/answer_address.h"
#include "udp_transport/multicast/offered_groups.h"
#include "udp_transport/receive/answer_credit.h"
#include "udp_transport/receive/recent_labels.h"

namespace sft::udp {

namespace {

constexpr std::size_t left_writers_max = 256;

/// Parts; what is missing beyond these is asked for later.
constexpr std::size_t asked_at_once_max = 8 * missing_max;

/// Calls `ask(Missing)` for each part of a sample that has not come; null: nothing of it has.
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

std::uint64_t sequence_of(const FirstHeader& first, const SequenceWatch& sequences) {
  const auto with = [&](std::uint32_t high) { return std::uint64_t{high} << 32 | first.label.sequence; };
  if ((first.flags & channel_follows) != 0) return with(first.channel.sequence_high);
  if ((first.flags & group_follows) != 0) return with(first.group.sequence_high);
  return sequences.widen(first.label.sequence);
}

}  // namespace

struct Reassembly::Incoming {
  core::EndpointId writer = 0;
  const TypeSupport* type = nullptr;
  Incoming* twin = nullptr;      ///< the next one with the same short id
  std::size_t place = 0;         ///< in set_streams()
  bool alive = true;             ///< its node answers
  std::size_t sample_bytes = 0;  ///< most that a body may have
  WantedMasks wanted;
  SequenceWatch sequences;  ///< of what was completed
  UnfinishedSamples unfinished;
  std::size_t unfinished_bytes = 0;  ///< of those that are described
  RecentLabels finished;
  std::unique_ptr<ArrivalWindow> window;    ///< null unless it is wanted reliably
  std::optional<SocketAddress> acks_go_to;  ///< as its last heartbeat said
  /// As a heartbeat said that nobody has confirmed yet: acks go there, too.
  std::optional<SocketAddress> acks_may_go_to;
  AnswerCredit credit;
  core::Announced node;
  core::IpAddress came_from;  ///< last
  OfferedGroups groups;
  RecentLabels elsewhere;  ///< of groups that were not offered: these come otherwise

  bool follows(std::uint32_t channel) const {
    const auto mark = window == nullptr ? std::nullopt : window->mark();
    return mark && mark->channel == channel;
  }

  /// A single heartbeat does not turn acks away from where they went before.
  void answer_to(const SocketAddress& address) {
    const bool confirmed = !acks_go_to || acks_may_go_to == address;
    if (confirmed) acks_go_to = address;
    acks_may_go_to.reset();
    if (acks_go_to != address) acks_may_go_to = address;
  }
};

Reassembly::Reassembly(const ReassemblyLimits& limits, std::shared_ptr<core::BufferPool> pool)
    : limits_(limits), pool_(std::move(pool)) {}

Reassembly::~Reassembly() = default;

void Reassembly::set_streams(std::span<const Stream> streams) {
  auto before = std::exchange(incoming_, {});
  by_stream_.clear();
  by_short_id_.clear();
  last_ = nullptr;
  windows_ = 0;
  for (std::size_t place = 0; place < streams.size(); ++place) {
    const Stream& stream = streams[place];
    std::unique_ptr<Incoming>& in = incoming_[stream.writer];
    if (const auto known = before.find(stream.writer); known != before.end()) {
      in = std::move(known->second);
      before.erase(known);
    } else {
      in = std::make_unique<Incoming>();
    }
    const std::size_t announced =
        stream.max_sample_bytes == 0 ? limits_.sample_bytes : stream.max_sample_bytes;
    in->writer = stream.writer;
    in->type = stream.type;
    in->place = place;
    in->node = stream.node;
    in->alive = stream.alive;
    in->sample_bytes = std::min(announced, limits_.sample_bytes);
    in->wanted.set(*stream.type, stream.masks);
    if (!stream.reliable) close_window(*in);
    if (stream.reliable && in->window == nullptr) open_window(*in);
    if (in->window != nullptr) in->window->set_awaited(stream.waits);
    windows_ += stream.reliable ? 1 : 0;
    by_stream_.push_back(in.get());
  }
  note_short_ids(streams);
  for (auto& [writer, in] : before) {
    close_window(*in);
    while (!in->unfinished.empty()) remove(*in, SampleLabel(in->unfinished.loose().back()->label()));
  }
}

/// Several writers may have one short id: those that live come first.
void Reassembly::note_short_ids(std::span<const Stream> streams) {
  for (const bool alive : {true, false}) {
    for (std::size_t place = 0; place < streams.size(); ++place) {
      if (streams[place].alive != alive) continue;
      Incoming** last = &by_short_id_[static_cast<std::uint32_t>(streams[place].writer)];
      while (*last != nullptr) last = &(*last)->twin;
      *last = by_stream_[place];
      by_stream_[place]->twin = nullptr;
    }
  }
}

void Reassembly::open_window(Incoming& in) {
  in.window = std::make_unique<ArrivalWindow>(limits_.channel);
  const auto left = std::ranges::find_if(left_, [&](const auto& item) { return item.first == in.writer; });
  if (left == left_.end()) return;
  in.window->join(left->second);
  left_.erase(left);
}

void Reassembly::close_window(Incoming& in) {
  if (in.window == nullptr) return;
  in.unfinished.forget_places();
  if (!in.unfinished.empty()) next_expiry_ = Time{};  // these can expire from now on
  const auto mark = in.window->mark();
  in.window.reset();
  in.acks_go_to.reset();
  in.acks_may_go_to.reset();
  if (!mark) return;
  if (left_.size() == left_writers_max) left_.erase(left_.begin());
  left_.emplace_back(in.writer, *mark);
}

Reassembly::Arrival Reassembly::accept(std::span<const std::byte> bytes, ArrivalTime now,
                                       const core::IpAddress& from) {
  packed_.clear();
  ahead_.clear();
  ++datagrams_;
  const bool is_following = kind_of(bytes) == DatagramKind::following;
  std::optional<Datagram> d = is_following ? std::nullopt : parse(bytes);
  const std::optional<Following> following = is_following ? parse_following(bytes) : std::nullopt;
  if (!d && !following) {
    ++counters_.malformed;
    return {};
  }
  Incoming* const in = find(d ? d->label().writer : following->label.writer, from,
                            [&](Incoming& one) { return fits(one, d, following); });
  if (in == nullptr) {
    ++counters_.unknown;
    return {};
  }
  in->credit.received(bytes.size());
  if (following) return accept_following(*in, *following, now);
  if ((d->first.flags & group_follows) != 0 && !place(*in, *d, now.steady)) return {};
  const WantedMasks::Named named = in->wanted.named_by(*d);
  return d->kind == DatagramKind::packed ? accept_packed(*in, *d, named, now)
                                         : accept_first(*in, *d, named, now);
}

/// Somebody may announce writers with the short ids of others, and the addresses of others, too. Of such
/// twins the datagram is of one whose node announced the address that it came from and that it fits, or else
/// of one that at least announced that address, or of the first one.
template <class Fits>
Reassembly::Incoming* Reassembly::find(std::uint32_t writer, const core::IpAddress& from, const Fits& fits) {
  if (last_ != nullptr && static_cast<std::uint32_t>(last_->writer) == writer) return last_;
  const auto known = by_short_id_.find(writer);
  if (known == by_short_id_.end()) return nullptr;
  if (known->second->twin == nullptr) return last_ = known->second;
  Incoming* from_there = nullptr;
  for (Incoming* in = known->second; in != nullptr; in = in->twin) {
    if (!is_announced(in->node, from)) continue;
    if (fits(*in)) return in;
    if (from_there == nullptr) from_there = in;
  }
  return from_there == nullptr ? known->second : from_there;
}

bool Reassembly::fits(Incoming& in, const std::optional<Datagram>& d,
                      const std::optional<Following>& following) {
  if (following) return in.unfinished.find(following->label) != nullptr;
  if ((d->first.flags & channel_follows) != 0 && in.follows(d->first.channel.channel)) return true;
  Datagram copy = *d;  // words of a mask are taken off
  const WantedMasks::Named named = in.wanted.named_by(copy);
  return named.mask != nullptr && !named.malformed &&
         std::max<std::size_t>(copy.first.total, copy.bytes_each) <= in.sample_bytes;
}

/// As if each sample had come by itself.
Reassembly::Arrival Reassembly::accept_packed(Incoming& in, const Datagram& packed,
                                              const WantedMasks::Named& named, ArrivalTime now) {
  PackedBodies bodies(packed);
  if (named.malformed || !bodies.sound()) {
    ++counters_.malformed;
    return {};
  }
  if (packed.bytes_each != 0 && named.mask != nullptr && packed.bytes_each <= in.sample_bytes) {
    const std::size_t bytes = detail::SampleLayout(in.type->slots()).bytes(packed.bytes_each);
    const std::size_t left = in.window == nullptr ? 0 : left_for_first_missing(in);
    pool_->take_kept(bytes, pool_->limit_bytes() / 4 + left, packed.samples, ahead_);
  }
  Arrival arrival{{}, in.place};
  Datagram d;
  d.kind = DatagramKind::first;
  for (std::uint32_t i = 0; i < packed.samples; ++i) {
    d.payload = bodies.next();
    d.first = header_behind(packed.first, i, static_cast<std::uint32_t>(d.payload.size()));
    Arrival one = accept_first(in, d, named, now, i > 0);
    arrival.in_channel |= one.in_channel;
    if (one.sample) packed_.push_back(std::move(one.sample));
  }
  ahead_.clear();
  arrival.packed = packed_;
  return arrival;
}

Reassembly::Arrival Reassembly::accept_first(Incoming& in, const Datagram& d, const WantedMasks::Named& named,
                                             ArrivalTime now, bool same_datagram) {
  ArrivalWindow::Met met{ArrivalWindow::Standing::wanted, 0};
  if (in.window != nullptr && (d.first.flags & channel_follows) != 0) {
    met = in.window->meet(d.first.channel, now.steady, same_datagram);
    if (met.standing == ArrivalWindow::Standing::known && gives_way(in, met.place, d.label(), now.steady))
      met = in.window->meet(d.first.channel, now.steady, same_datagram);
    if (met.standing == ArrivalWindow::Standing::known && met.place != 0)
      in.window->doubt(met.place, d.label().sequence);
    drop_abandoned(in);
  }
  UnfinishedSample* sample = in.unfinished.find(d.label());
  const bool repeated =
      sample != nullptr ? sample->described() : met.place == 0 && in.finished.contains(d.label());
  const Arrival nothing{{}, in.place, met.place != 0};
  const bool is_wanted = met.standing == ArrivalWindow::Standing::wanted;
  if ((d.first.flags & group_follows) != 0) {
    const bool is_old = sample != nullptr || in.finished.contains(d.label());
    if (is_wanted || !is_old) in.groups.note(d.first.group.group, !is_wanted);
  }
  if (is_wanted && met.place != 0 && repeated) join_channel(in, *sample, met.place);
  if (repeated || !is_wanted) return nothing;

  core::SampleHandle buffer;
  if (const Refusal why = describe(in, d, named, met.place, buffer); why != Refusal::none)
    return refuse(in, d, met.place, why);
  const std::size_t body_offset = detail::SampleLayout(in.type->slots()).body_offset;
  if (sample == nullptr && d.payload.size() == d.first.total) {  // the whole sample
    if (!d.payload.empty()) std::memcpy(buffer->data + body_offset, d.payload.data(), d.payload.size());
    in.finished.add(d.label());
    return complete(in, std::move(buffer), d.first, met.place, now);
  }
  if (met.place != 0) in.window->begun(met.place, d.label(), buffer);
  if (sample == nullptr) sample = &begin(in, d.label(), met.place, now.steady);
  in.unfinished.set_place(*sample, met.place);
  sample->describe(d.first, body_offset, std::move(buffer));
  in.unfinished_bytes += d.first.total;
  parked_bytes_ -= sample->parked_bytes();
  sample->add(0, d.payload, limits_.gaps, now.steady);
  Arrival arrival = proceed(in, *sample, sample->unpark(limits_.gaps, now.steady), now);
  arrival.in_channel = met.place != 0;  // those before it may have turned out to be lost
  return arrival;
}

/// Another sample has begun at that place, and gets no further: what began it may not have been true.
bool Reassembly::gives_way(Incoming& in, std::uint64_t place, const SampleLabel& label, Time now) {
  constexpr std::chrono::milliseconds claim_holds{20};
  const std::optional<SampleLabel> claimed = in.window->begun_at(place);
  if (!claimed || *claimed == label) return false;
  const UnfinishedSample* const sample = in.unfinished.find(*claimed);
  if (sample != nullptr && now - sample->last_progress() < claim_holds) return false;
  in.window->give_back(place, now);
  return true;
}

/// It had begun before it was wanted reliably.
void Reassembly::join_channel(Incoming& in, UnfinishedSample& sample, std::uint64_t place) {
  in.unfinished.set_place(sample, place);
  in.window->begun(place, sample.label(), sample.buffer());
}

/// False if it is of a group that is not known here, or is not meant for those who read here now.
bool Reassembly::place(Incoming& in, Datagram& d, Time now) {
  if (!in.groups.place(d.first, now, in.window == nullptr ? nullptr : &in.window->channels())) {
    in.elsewhere.add(d.label());
    reports_due_ = reports_due_ || in.groups.due();
    return false;
  }
  reports_due_ = reports_due_ || in.groups.due();
  if (in.window != nullptr && (d.first.flags & channel_follows) != 0) in.window->spread_asking();
  return true;
}

std::optional<Reassembly::Joining> Reassembly::accept_offer(std::span<const std::byte> bytes,
                                                            SocketAddress from, ArrivalTime now) {
  const std::optional<GroupOffer> offer = parse_group_offer(bytes);
  if (!offer) {
    ++counters_.malformed;
    return {};
  }
  Incoming* const in = find(offer->writer, from.ip, [](Incoming&) { return true; });
  if (in == nullptr) {
    ++counters_.unknown;
    return {};
  }
  const std::optional<SocketAddress> report_to = answer_address(in->node, from.ip, offer->port);
  if (!report_to) {
    ++counters_.unknown;
    return {};
  }
  const bool anew = in->groups.hear(*offer, *report_to, now.steady);
  reports_due_ = reports_due_ || in->groups.due();
  return Joining{offer->address, anew};
}

std::vector<std::uint32_t> Reassembly::groups() const {
  std::vector<std::uint32_t> groups;
  for (const Incoming* in : by_stream_) in->groups.addresses(groups);
  return groups;
}

void Reassembly::report(const SendReport& send) {
  if (!std::exchange(reports_due_, false)) return;
  for (Incoming* in : by_stream_) in->groups.report(send);
}

/// What was sent reliably, and there is no memory for as yet, will come again.
Reassembly::Arrival Reassembly::refuse(Incoming& in, const Datagram& d, std::uint64_t place, Refusal why) {
  const Arrival nothing{{}, in.place, place != 0};
  if (place != 0 && why == Refusal::over_limit && d.first.total <= in.sample_bytes) {
    ++counters_.over_limit;
    return nothing;
  }
  if (place != 0 && why == Refusal::malformed) {
    ++counters_.malformed;
    in.window->refuse_or_pass(place);
    return nothing;
  }
  if (place != 0) in.window->pass(place);
  drop(in, d.label(),
       why == Refusal::malformed  ? counters_.malformed
       : why == Refusal::unwanted ? counters_.unknown
                                  : counters_.over_limit);
  return nothing;
}

Reassembly::Arrival Reassembly::accept_following(Incoming& in, const Following& d, ArrivalTime now) {
  drop_abandoned(in);  // when readers took something, too
  UnfinishedSample* sample = in.unfinished.find(d.label);
  if (sample == nullptr) {
    if (in.finished.contains(d.label) || in.elsewhere.contains(d.label)) return {};
    sample = &begin(in, d.label, 0, now.steady);
  }
  if (!sample->described()) {
    park(in, *sample, d, now.steady);
    return {};
  }
  const std::uint32_t had = sample->received().covered();
  const auto added = sample->add(d.offset, d.payload, limits_.gaps, now.steady);
  if (added == UnfinishedSample::Added::beyond_body) {
    ++counters_.malformed;  // the sample may be honest
    return {};
  }
  const bool again = added == UnfinishedSample::Added::yes && sample->received().covered() == had;
  if (again && sample->place() != 0) in.window->came_again(sample->place());
  return proceed(in, *sample, added, now);
}

/// After something was added to a described sample, or refused. What is reliable can come again.
Reassembly::Arrival Reassembly::proceed(Incoming& in, UnfinishedSample& sample, UnfinishedSample::Added added,
                                        ArrivalTime now) {
  using Added = UnfinishedSample::Added;
  const bool in_channel = sample.place() != 0;
  if (added != Added::yes) [[unlikely]] {
    std::uint64_t& counter = added == Added::beyond_body ? counters_.malformed : counters_.over_limit;
    if (!in_channel) {
      drop(in, SampleLabel(sample.label()), counter);
      return {{}, in.place, false};
    }
    ++counter;
  }
  if (!sample.whole()) return {{}, in.place, false};
  const FirstHeader first = sample.first();
  const std::uint64_t place = sample.place();
  std::unique_ptr<UnfinishedSample> whole = remove(in, first.label);
  in.finished.add(first.label);
  Arrival arrival = complete(in, whole->take_buffer(), first, place, now);
  keep_spare(std::move(whole));
  return arrival;
}

Reassembly::Arrival Reassembly::complete(Incoming& in, core::SampleHandle sample, const FirstHeader& first,
                                         std::uint64_t place, ArrivalTime now) {
  const detail::SampleLayout layout(in.type->slots());
  detail::SampleHeader& header = sample->header();
  header.slots = static_cast<std::uint32_t>(in.type->slots());
  header.writer = in.writer;
  header.sequence = sequence_of(first, in.sequences);
  header.source_stamp_ns = first.stamp_ns;
  header.type_hash = in.type->hash();
  header.body_offset = static_cast<std::uint32_t>(layout.body_offset);
  header.body_bytes = first.total;
  sample->trust_header();
  sample->receive_stamp_ns = now.realtime_ns;
  std::byte* body = sample->data + layout.body_offset;
  std::memcpy(body - detail::encapsulation_bytes, detail::encapsulation_cdr_le.data(),
              detail::encapsulation_bytes);

  detail::SampleState state;
  state.body = body;
  state.body_bytes = first.total;
  state.mask = &sample->mask;
  const detail::WalkStatus status =
      detail::build_index(state, in.type->type(), {sample->index(), in.type->slots()});
  if (status != detail::WalkStatus::ok || header.sequence == 0) {
    ++counters_.malformed;
    if (place != 0) in.window->refuse_or_pass(place);
    return {{}, in.place, place != 0};
  }
  if (!believes(in, {header.sequence, place, datagrams_, header.source_stamp_ns}, now.steady)) {
    ++counters_.malformed;
    if (place != 0) in.window->refuse(place);
    return {{}, in.place, place != 0};
  }
  sample->numbering = in.sequences.numbering();
  if (place != 0) in.window->whole(place, sample);
  drop_abandoned(in);
  return {std::move(sample), in.place, place != 0};
}

/// A sample that waits under a sequence that turns out to be wrong has to come again. A writer that does not
/// answer any more sends nothing anew: samples behind its newest one are repeated by somebody else.
bool Reassembly::believes(Incoming& in, const SequenceWatch::Claim& claim, Time now) {
  if (!in.alive && claim.place == 0 && claim.sequence < in.sequences.newest()) return false;
  const std::uint32_t numbering = in.sequences.numbering();
  const bool believed = in.sequences.believes(claim, now);
  const bool begins_anew = in.sequences.numbering() != numbering;
  if (in.window != nullptr && begins_anew && in.sequences.newest_was_wrong())
    in.window->distrust_above(claim.sequence);
  return believed;
}

/// Checks what a first datagram claims, before anything is allocated, and takes the memory for it.
Reassembly::Refusal Reassembly::describe(Incoming& in, const Datagram& d, const WantedMasks::Named& named,
                                         std::uint64_t place, core::SampleHandle& buffer) {
  if (named.malformed) return Refusal::malformed;
  if (named.mask == nullptr) return Refusal::unwanted;
  if (d.payload.size() > d.first.total) return Refusal::malformed;
  if (d.first.total > in.sample_bytes) return Refusal::over_limit;
  if (!ahead_.empty()) {
    buffer = std::move(ahead_.back());
    ahead_.pop_back();
  } else {
    buffer = place == 0 ? take_buffer(in, d) : take_reliable_buffer(in, d, place);
  }
  if (!buffer) return Refusal::over_limit;
  buffer->mask = *named.mask;
  buffer->min_period_us = d.first.rate.min_period_us;
  buffer->ordinal = d.first.rate.ordinal;
  buffer->addressee = d.first.history.reader;
  buffer->oldest_retained = d.first.history.oldest;
  buffer->merged = (d.first.flags & merged_masks) != 0;
  return Refusal::none;
}

/// Where memory is short, the writer's own older samples make room. Some is left to what this node publishes:
/// what others send, or what its subscribers keep, must not silence it.
core::SampleHandle Reassembly::take_buffer(Incoming& in, const Datagram& d) {
  const std::size_t total = d.first.total;
  const bool unfinished = d.payload.size() != total;
  while (unfinished && in.unfinished_bytes + total > limits_.unfinished_bytes && drop_oldest(in, d.label())) {
  }
  const std::size_t bytes = detail::SampleLayout(in.type->slots()).bytes(total);
  const std::size_t left_bytes = pool_->limit_bytes() / 4;
  core::SampleHandle buffer = pool_->take(bytes, left_bytes);
  while (!buffer && drop_oldest(in, d.label())) buffer = pool_->take(bytes, left_bytes);
  return buffer;
}

/// Nothing makes room for it: it can come again later. Those behind the first that is missing leave room for
/// that one: without it none of them is ever let go of.
core::SampleHandle Reassembly::take_reliable_buffer(Incoming& in, const Datagram& d, std::uint64_t place) {
  const std::size_t total = d.first.total;
  if (in.unfinished_bytes > 0 && in.unfinished_bytes + total > limits_.unfinished_bytes) return {};
  const std::size_t left = place == in.window->next_place() ? 0 : left_for_first_missing(in);
  return pool_->take(detail::SampleLayout(in.type->slots()).bytes(total), pool_->limit_bytes() / 4 + left);
}

std::size_t Reassembly::left_for_first_missing(const Incoming& in) const {
  return std::min(detail::SampleLayout(in.type->slots()).bytes(in.sample_bytes), pool_->limit_bytes() / 4);
}

void Reassembly::park(Incoming& in, UnfinishedSample& sample, const Following& d, Time now) {
  const std::size_t bytes = UnfinishedSample::bytes_to_park(d.payload);
  if (d.payload.size() > in.sample_bytes || d.offset > in.sample_bytes - d.payload.size()) {
    drop(in, sample.label(), counters_.malformed);
    return;
  }
  if (parked_bytes_ + bytes > limits_.parked_bytes) {
    drop(in, sample.label(), counters_.over_limit);
    return;
  }
  sample.park(d.offset, d.payload, now);
  parked_bytes_ += bytes;
}

UnfinishedSample& Reassembly::begin(Incoming& in, const SampleLabel& label, std::uint64_t place, Time now) {
  const auto& loose = in.unfinished.loose();
  const auto of_variant = [&] {
    return static_cast<std::size_t>(std::ranges::count_if(
        loose, [&](const auto& sample) { return sample->label().variant == label.variant; }));
  };
  const auto full = [&] {
    return loose.size() >= limits_.unfinished_per_writer || of_variant() >= limits_.unfinished_per_variant;
  };
  while (place == 0 && full() && drop_oldest(in, label)) {
  }
  if (spare_.empty()) spare_.push_back(std::make_unique<UnfinishedSample>());
  std::unique_ptr<UnfinishedSample> sample = std::move(spare_.back());
  spare_.pop_back();
  sample->begin(label, now);
  sample->set_place(place);
  ++unfinished_;
  if (!next_expiry_) next_expiry_ = now + limits_.patience;
  return in.unfinished.add(std::move(sample));
}

/// Never the sample of the label itself, nor one that is sent reliably. False if there is no other.
bool Reassembly::drop_oldest(Incoming& in, const SampleLabel& same_variant_first) {
  const UnfinishedSample* oldest = nullptr;
  for (const auto& sample : in.unfinished.loose()) {
    if (sample->label() == same_variant_first) continue;
    const bool same_variant = sample->label().variant == same_variant_first.variant;
    if (oldest == nullptr || same_variant) oldest = sample.get();
    if (same_variant) break;
  }
  if (oldest != nullptr) drop(in, SampleLabel(oldest->label()), counters_.incomplete);
  return oldest != nullptr;
}

/// Counts a sample that is given up, whether it had begun or not. What still comes of it is ignored.
void Reassembly::drop(Incoming& in, const SampleLabel& label, std::uint64_t& counter) {
  ++counter;
  in.finished.add(label);
  std::unique_ptr<UnfinishedSample> sample = remove(in, label);
  if (sample == nullptr) return;
  if (sample->place() != 0 && in.window != nullptr) in.window->pass(sample->place());
  keep_spare(std::move(sample));
}

/// What its writer does not have any more, and what begins anew.
void Reassembly::drop_abandoned(Incoming& in) {
  if (in.window == nullptr) return;
  if (in.window->has_abandoned()) [[unlikely]] {
    for (const SampleLabel& label : in.window->take_abandoned()) drop(in, label, counters_.incomplete);
  }
  if (in.window->has_given_back()) [[unlikely]] {
    for (const SampleLabel& label : in.window->take_given_back()) {
      ++counters_.incomplete;
      if (auto sample = remove(in, label)) keep_spare(std::move(sample));
    }
  }
}

void Reassembly::keep_spare(std::unique_ptr<UnfinishedSample> sample) {
  sample->clear();
  if (spare_.size() < limits_.unfinished_per_writer) spare_.push_back(std::move(sample));
}

std::unique_ptr<UnfinishedSample> Reassembly::remove(Incoming& in, const SampleLabel& label) {
  std::unique_ptr<UnfinishedSample> sample = in.unfinished.remove(label);
  if (sample == nullptr) return nullptr;
  if (sample->described()) in.unfinished_bytes -= sample->first().total;
  parked_bytes_ -= sample->parked_bytes();
  if (--unfinished_ == 0) next_expiry_.reset();
  return sample;
}

/// What has a place in a channel can come again: its window decides.
void Reassembly::expire(Time now) {
  if (!next_expiry_ || now < *next_expiry_) return;
  std::optional<Time> next;
  for (auto& [writer, in] : incoming_) {
    const auto& loose = in->unfinished.loose();
    for (std::size_t i = 0; i < loose.size();) {
      const Time expiry = loose[i]->last_progress() + limits_.patience;
      if (expiry <= now) {
        drop(*in, SampleLabel(loose[i]->label()), counters_.incomplete);
      } else {
        next = next ? std::min(*next, expiry) : expiry;
        ++i;
      }
    }
  }
  next_expiry_ = next;
}

Reassembly::Arrival Reassembly::accept_heartbeat(std::span<const std::byte> bytes, SocketAddress from,
                                                 ArrivalTime now) {
  const std::optional<Heartbeat> heartbeat = parse_heartbeat(bytes);
  if (!heartbeat) {
    ++counters_.malformed;
    return {};
  }
  Incoming* const found =
      find(heartbeat->writer, from.ip, [&](Incoming& one) { return one.follows(heartbeat->channel); });
  if (found == nullptr || found->window == nullptr) {
    ++counters_.unknown;
    return {};
  }
  Incoming& in = *found;
  const std::optional<SocketAddress> answers_to = answer_address(in.node, from.ip, heartbeat->port);
  if (!answers_to) {
    ++counters_.unknown;
    return {};
  }
  in.credit.received(bytes.size());
  in.answer_to(*answers_to);
  in.window->hear(*heartbeat, now.steady);
  drop_abandoned(in);
  return {{}, in.place, true};
}

std::optional<SocketAddress> Reassembly::report_address(const core::IpAddress& from,
                                                        std::uint16_t port) const {
  const Incoming* its = nullptr;
  for (const Incoming* in : by_stream_) {
    if (is_announced(in->node, from)) return answer_address(in->node, from, port);
    if (in->came_from == from) its = in;
  }
  return its == nullptr ? std::nullopt : answer_address(its->node, from, port);
}

void Reassembly::came_from(std::size_t stream, const core::IpAddress& ip) {
  if (stream < by_stream_.size()) by_stream_[stream]->came_from = ip;
}

ArrivalWindow* Reassembly::window(std::size_t stream) {
  return stream < by_stream_.size() ? by_stream_[stream]->window.get() : nullptr;
}

void Reassembly::answer(Time now, const SendAck& send) {
  if (windows_ == 0) return;
  for (Incoming* in : by_stream_) {
    if (in->window != nullptr && in->acks_go_to) answer(*in, now, send);
  }
}

Reassembly::Time Reassembly::next_answer() const {
  Time next = Time::max();
  if (windows_ == 0) return next;
  for (const Incoming* in : by_stream_) {
    if (in->window != nullptr && in->acks_go_to) next = std::min(next, in->window->next_look());
  }
  return next;
}

void Reassembly::answer(Incoming& in, Time now, const SendAck& send) {
  ArrivalWindow& window = *in.window;
  const auto came_at = [&](const SampleLabel& label) {
    const UnfinishedSample* sample = in.unfinished.find(label);
    return sample == nullptr ? Time{} : sample->last_progress();
  };
  std::vector<ArrivalWindow::Gap> gaps;
  if (now >= window.next_look()) gaps = window.due_gaps(now, came_at, asked_at_once_max);
  drop_abandoned(in);
  if (gaps.empty() && !window.ack_due()) return;
  Ack ack = window.ack(static_cast<std::uint32_t>(in.writer));
  const std::size_t copies = in.acks_may_go_to ? 2 : 1;
  const auto send_ack = [&](const Ack& part) {
    if (!in.credit.covers(copies * part.bytes())) return;
    in.credit.spend(copies * part.bytes());
    send(*in.acks_go_to, part);
    if (in.acks_may_go_to) send(*in.acks_may_go_to, part);
  };
  std::size_t asked = 0;
  const auto ask = [&](const Missing& part) {
    if (++asked > asked_at_once_max || !in.credit.covers(copies * (ack.bytes() + missing_bytes))) return;
    if (ack.missing_count == missing_max) {
      send_ack(ack);
      ack.missing_count = 0;
    }
    ack.missing[ack.missing_count++] = part;
  };
  for (const ArrivalWindow::Gap& gap : gaps) {
    const UnfinishedSample* sample = gap.label ? in.unfinished.find(*gap.label) : nullptr;
    const std::size_t before = asked;
    for_each_missing(static_cast<std::uint32_t>(gap.ordinal), sample, ask);
    window.asked_for(gap.place, static_cast<std::uint32_t>(asked - before));
  }
  send_ack(ack);
}

}  // namespace sft::udp
