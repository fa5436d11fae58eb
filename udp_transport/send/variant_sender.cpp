#include "udp_transport/send/variant_sender.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;

/// So that a pack is cut into what one system call takes, whatever the lengths of its samples.
constexpr std::size_t pack_bytes_most = 44'000;
constexpr std::size_t pack_datagrams = 30;
/// A quarter of what is acknowledged at a time or kept: the next one can be filled meanwhile.
constexpr std::size_t pack_samples_max = 1024;
/// In a datagram there is room for so many at least: with fewer, sharing it gains little.
constexpr std::size_t samples_per_datagram_min = 4;

/// Of what was postponed: looked at in between whether it is still needed.
constexpr std::size_t copied_at_a_time = 128 * 1024;

}  // namespace

VariantSender::VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                             std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : writer_(static_cast<std::uint32_t>(spec.id)),
      waits_for_readers_(spec.max_blocking.count() > 0),
      type_(*spec.type),
      side_(std::move(side)),
      tally_(std::move(tally)),
      jobs_(std::move(jobs)) {}

std::size_t VariantSender::send(const Group& group, const core::SampleHandle& sample) noexcept try {
  if (!blank_) blank_ = jobs_->take();
  Job& job = *blank_;
  if (!encode(group, *sample, job)) {
    group.tally->dropped();
    return group.lanes.size();
  }
  if (group.gate != nullptr) {
    job.first.flags |= rate_follows;
    job.first.rate = {group.gate->min_period_us(), group.gate->ordinal()};
  }
  if (sample->postponed != nullptr && !job.is_small()) {
    if (goes_ahead(group)) return send_ahead(group, sample);
    sample->complete();
  }
  return group.multicast == nullptr ? distribute(group, sample) : send_together(group, sample);
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  group.tally->dropped();
  blank_ = {};
  blank_kept_ = false;
  return group.lanes.size();
}

/// For what is sent later. A channel that has the job counts what it holds: it has a copy of the body. Where
/// it is a pack there is no sample: it keeps all by itself.
void VariantSender::keep_for_later(const core::SampleHandle& sample) {
  if (!blank_->sample && !blank_kept_) blank_->sample = sample;
  blank_kept_ = blank_kept_ || blank_->is_pack();
}

/// A large one. Where it lies in borrowed memory, as much as is needed while readers keep up may be held
/// there, since others that take samples from there are not to miss any; beyond that it is copied.
void VariantSender::keep_in_channels(const core::SampleHandle& sample) {
  if (side_->pool == nullptr || sample->owner == side_->pool) return keep_for_later(sample);
  if (jobs_->may_borrow(sample->capacity)) {
    keep_for_later(sample);
    return blank_->borrow();
  }
  core::SampleHandle copy = side_->pool->take(
      std::max(blank_->projection.bytes(), sizeof(detail::SampleHeader)), side_->pool->limit_bytes() / 4);
  copy ? blank_->copy_body(std::move(copy)) : blank_->copy_body();
  blank_kept_ = true;
}

void VariantSender::release_blank() {
  if (std::exchange(blank_kept_, false) || blank_->sample) blank_ = {};
}

/// The blank job. What a pack's destinations miss is the same, as a rule.
std::size_t VariantSender::distribute(const Group& group, const core::SampleHandle& sample) {
  cut_for_ = 0;
  std::size_t missed = 0;
  const bool is_reliable = std::ranges::any_of(group.channels, [](const auto& c) { return c != nullptr; });
  if (is_reliable && !blank_->is_small()) keep_in_channels(sample);
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    const std::size_t here = send_alone(group, i, sample);
    missed = blank_->is_pack() ? std::max(missed, here) : missed + here;
  }
  group.tally->sent(blank_->first.total, blank_->whole_bytes, blank_->samples());
  release_blank();
  return missed;
}

/// A large body that is still in the program's memory can be sent from there, ahead of being copied: nothing
/// has to go before it, and there is a connection for it.
bool VariantSender::goes_ahead(const Group& group) const {
  if (group.multicast != nullptr || group.late_reader != 0 || group.lanes.size() != 1) return false;
  Lane& lane = *group.lanes.front();
  return !lane.is_late() && lane.idle() && lane.destination().bulk_in_use() != nullptr;
}

/// The blank job, by the only lane.
std::size_t VariantSender::send_ahead(const Group& group, const core::SampleHandle& sample) {
  located_.clear();
  sample->postponed->locate(blank_->projection.segments(), located_);
  const std::shared_ptr<Lane>& lane = group.lanes.front();
  const std::shared_ptr<Channel>& channel = group.channels.front();
  const std::optional<std::size_t> missed =
      channel == nullptr ? send_ahead_once(lane, sample) : send_ahead_reliably(*lane, channel, sample);
  if (!missed) {
    sample->complete();
    return distribute(group, sample);
  }
  group.tally->sent(blank_->first.total, blank_->whole_bytes, 1);
  release_blank();
  return *missed;
}

/// What the sending thread has to go on with is copied for it.
std::size_t VariantSender::send_ahead_once(const std::shared_ptr<Lane>& lane,
                                           const core::SampleHandle& sample) {
  Job& job = *blank_;
  const std::uint32_t sent = send_located(job.first, lane->destination());
  lane->stay_behind(lane->destination().position());
  if (sent == job.first.total) return 0;
  job.sent_bytes = sent;
  sample->complete();
  keep_for_later(sample);
  return enqueue(lane) ? 0 : 1;
}

/// What may have to be sent again is copied: not what has been acknowledged by then. None if something else
/// has to be sent before.
std::optional<std::size_t> VariantSender::send_ahead_reliably(Lane& lane,
                                                              const std::shared_ptr<Channel>& channel,
                                                              const core::SampleHandle& sample) {
  keep_for_later(sample);
  std::optional<Channel::Posted> posted =
      channel->post_ahead(blank_, blank_->first, patience_.count() == 0 ? nullptr : &patience_);
  if (!posted) return {};
  Channel::Piece& piece = *posted->piece;
  piece.range.begin = send_located(piece.first, channel->destination());
  channel->stay_behind(channel->destination().position());
  while (!sample->postponed->empty() && channel->keeps(piece.ordinal))
    sample->postponed->make(copied_at_a_time);
  if (piece.range.begin == piece.first.total) {
    posted->waits = channel->finished(piece, Clock::now());
  } else {
    channel->put_back(piece);
    posted->waits = true;
  }
  return note(*posted, channel, lane, 1);
}

/// As far as it may go now. Returns how many bytes of the body have left.
std::uint32_t VariantSender::send_located(const FirstHeader& first, Destination& to) {
  Connection& by = *to.bulk_in_use();
  const std::size_t cut_for = to.datagram_bytes();
  Fragmenter fragments({first, blank_->mask->words, located_}, cut_for);
  while (!fragments.done()) {
    const Clock::time_point now = Clock::now();
    const std::size_t allowed = side_->sender.allowance(to, tally_->limit, ResendWindow::Size::large, now);
    if (allowed == 0) break;
    Fragmenter next = fragments;
    next.next(batch_, std::min(allowed, to.batch_bytes()), to.datagrams_per_call());
    if (send_batch(to, by, cut_for, now) != SendOutcome::sent) break;
    fragments = next;
  }
  return fragments.offset();
}

std::size_t VariantSender::send_alone(const Group& group, std::size_t place,
                                      const core::SampleHandle& sample) {
  Job& job = *blank_;
  const std::shared_ptr<Lane>& lane = group.lanes[place];
  if (group.channels[place] != nullptr) return send_reliably(lane, group.channels[place]);
  const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::sent) return 0;
  if (outcome == SendOutcome::would_wait) {
    keep_for_later(sample);
    return enqueue(lane) ? 0 : job.samples();
  }
  lane->losses()->lost(job.first.total, job.whole_bytes, job.samples());
  return job.samples();
}

/// The blank job. Each reliable member keeps it in its channel, for repairs, or to send it itself while the
/// member does not hear the group or has no room. Copies for others of those that do not hear it have no mark
/// of the group.
std::size_t VariantSender::send_together(const Group& group, const core::SampleHandle& sample) {
  MulticastGroup& together = *group.multicast;
  const std::uint64_t ordinal = together.next_ordinal(std::chrono::steady_clock::now());
  const bool small = blank_->is_small();
  const bool has_room = together.is_answered() && together.lane()->has_room() && !together.broken();
  cut_for_ = 0;
  group.tally->sent(blank_->first.total, blank_->whole_bytes, 1);
  std::size_t missed = 0;
  if (!small) keep_in_channels(sample);
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    if (group.channels[i] == nullptr) continue;
    if (small && !std::exchange(blank_kept_, true)) blank_->copy_body();
    missed += keep_together(group, i, ordinal, has_room);
  }
  const MulticastGroup::BestEffort others = together.best_effort();
  if (has_room || others.some_hear) {
    // The job is shared by now, and what it says of itself is for the group alone.
    blank_->first.flags |= group_follows;
    blank_->first.group = {together.name().number, static_cast<std::uint32_t>(sample->sequence >> 32),
                           ordinal};
    missed += send_to_group(group, sample) ? 0 : 1;
  }
  release_blank();
  return others.some_do_not ? missed + send_to_the_deaf(group, sample) : missed;
}

std::size_t VariantSender::send_to_the_deaf(const Group& group, const core::SampleHandle& sample) {
  if (!blank_) blank_ = jobs_->take();
  if (!encode(group, *sample, *blank_)) return 0;
  cut_for_ = 0;
  std::size_t missed = 0;
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    if (group.channels[i] == nullptr && !group.multicast->hears(i)) missed += send_alone(group, i, sample);
  }
  release_blank();
  return missed;
}

std::size_t VariantSender::keep_together(const Group& group, std::size_t place, std::uint64_t ordinal,
                                         bool has_room) {
  MulticastGroup& together = *group.multicast;
  const std::shared_ptr<Channel>& channel = group.channels[place];
  const bool elsewhere = has_room && together.hears(place);
  const Channel::Posted posted = channel->post_shared(blank_, blank_->first, elsewhere);
  together.placed(place, ordinal, posted.kept.ordinal);
  return note(posted, channel, *group.lanes[place], 1);
}

bool VariantSender::send_to_group(const Group& group, const core::SampleHandle& sample) {
  MulticastGroup& together = *group.multicast;
  const std::shared_ptr<Lane>& lane = together.lane();
  Job& job = *blank_;
  if (!together.is_answered()) {  // those that heard it are silent
    if (together.has_left(job, true)) side_->sender.look_again();
    return false;
  }
  if (together.broken()) {
    if (together.has_left(job, false)) side_->sender.look_again();  // who would have heard it asks for it
    return true;
  }
  const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::would_wait) {
    keep_for_later(sample);
    return enqueue(MulticastGroup::lane_of(group.multicast));
  }
  if (together.has_left(job, outcome != SendOutcome::sent)) side_->sender.look_again();
  return outcome == SendOutcome::sent;
}

bool VariantSender::Held::follows(const core::SampleBuffer& sample, std::size_t bytes) const {
  if (!pack->is_pack()) return true;
  return sample.sequence == pack->sequence + pack->samples() &&
         sample.source_stamp_ns == pack->first.stamp_ns && pack->samples() < pack_samples_max &&
         pack->packed_bytes() + bytes <= pack_bytes_max;
}

VariantSender::Held& VariantSender::held_for(const Group& group) {
  const auto known = std::ranges::find(held_, &group, &Held::group);
  if (known != held_.end()) return *known;
  std::size_t datagram_bytes = datagram_bytes_max;
  for (const auto& lane : group.lanes)
    datagram_bytes = std::min(datagram_bytes, lane->destination().datagram_bytes());
  const std::size_t header =
      first_header_bytes + channel_bytes + length_bytes + group.wire->words.size() * sizeof(std::uint64_t);
  // One that every path takes in a datagram, so that none ever has to be cut.
  const std::size_t sample_bytes = std::min({datagram_bytes_min - header, side_->max_sample_bytes,
                                             (datagram_bytes - header) / samples_per_datagram_min});
  return held_.emplace_back(
      Held{&group, jobs_->take(), sample_bytes, std::min(pack_bytes_most, pack_datagrams * datagram_bytes)});
}

VariantSender::Hold VariantSender::hold(const Group& group, const core::SampleHandle& sample) noexcept try {
  if (!group.packs || group.multicast != nullptr) return Hold::unfit;
  if (!projected_) projected_ = jobs_->take();
  detail::Projection& body = projected_->projection;
  if (!body.project(core::state_of(*sample, type_.slots()), group.plan)) return Hold::unfit;
  Held& held = held_for(group);
  if (body.bytes() > held.sample_bytes_max) return Hold::unfit;
  if (!held.follows(*sample, body.bytes())) return Hold::full;
  if (!held.pack->is_pack()) {
    describe(group, *sample, *held.pack);
    held.pack->whole_bytes = 0;
  }
  held.pack->pack(body.segments());
  held.pack->whole_bytes += sample->whole_bytes;
  return Hold::held;
} catch (const std::bad_alloc&) {
  return Hold::unfit;
}

std::size_t VariantSender::flush() noexcept {
  std::size_t missed = 0;
  for (const Held& held : held_) {
    if (held.pack->is_pack()) missed = std::max(missed, send_pack(held));
  }
  held_.clear();
  return missed;
}

std::size_t VariantSender::send_pack(const Held& held) noexcept try {
  held.pack->seal();
  JobHandle before = std::exchange(blank_, held.pack);
  const std::size_t missed = distribute(*held.group, {});
  blank_ = std::move(before);
  return missed;
} catch (const std::bad_alloc&) {
  for (std::size_t i = 0; i < held.pack->samples(); ++i) held.group->tally->dropped();
  blank_ = {};
  blank_kept_ = false;
  return held.pack->samples();
}

/// The blank job waits in the lane of a late reader: its history goes first, and has to go for nothing.
/// Returns how many older samples had to go for it.
std::size_t VariantSender::send_after_history(const std::shared_ptr<Lane>& lane) {
  if (blank_->is_small() && !std::exchange(blank_kept_, true)) blank_->copy_body();
  if (patience_.count() > 0) lane->await_room(*blank_, patience_);
  return enqueue(lane) ? 0 : 1;
}

/// Returns how many older samples had to go for it.
std::size_t VariantSender::send_reliably(const std::shared_ptr<Lane>& lane,
                                         const std::shared_ptr<Channel>& channel) {
  Job& job = *blank_;
  const std::size_t job_samples = job.samples();
  const bool small = job.is_small();
  if (lane->is_late() && (!lane->idle() || !channel->has_room(job))) return send_after_history(lane);
  if (lane->is_late()) lane->mark(job);
  if (small && !std::exchange(blank_kept_, true) && !job.is_pack()) job.copy_body();
  const Clock::time_point now = Clock::now();
  const bool at_once = small && may_send_now(channel->destination(), job, now);
  const Channel::Posted posted =
      channel->post(blank_, job.first, at_once, patience_.count() == 0 ? nullptr : &patience_);
  if (posted.piece) send_now(*channel, *posted.piece, posted.waited ? Clock::now() : now);
  return note(posted, channel, *lane, job_samples);
}

/// Wakes who has to look after it. Returns how many older samples had to go for it, of as many as it is.
std::size_t VariantSender::note(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel,
                                Lane& lane, std::size_t job_samples) {
  if (posted.was_at_rest) {
    side_->sender.schedule(channel);
  } else if (posted.waits) {
    side_->sender.look_again();
  }
  const ResendWindow::Kept& kept = posted.kept;
  for (std::size_t i = 0; i < kept.dropped; ++i)
    lane.losses()->lost(i == 0 ? kept.dropped_bytes : 0, i == 0 ? kept.dropped_whole_bytes : 0);
  side_->over_limit.fetch_add(kept.dropped, std::memory_order_relaxed);
  // Who waited for room in vain is told of what may have arrived, too: there was no word of it in all that
  // time.
  const std::size_t gone = kept.dropped + (waits_for_readers_ ? kept.unacknowledged : 0);
  return std::min(gone, job_samples);
}

/// One call for a small body; a pack may take some. `would_wait` where the sending thread has to do it.
SendOutcome VariantSender::send_at_once(const EncodedBody& body, Destination& to, Connection& by,
                                        Clock::time_point now) {
  const std::size_t datagram_bytes = to.datagram_bytes();
  Fragmenter fragments(body, datagram_bytes);
  do {
    fragments.next(batch_, batch_bytes_max, body.packed ? to.datagrams_per_call() : batch_datagrams_max);
    if (!body.packed && (!fragments.done() || batch_.datagrams() > to.datagrams_per_call()))
      return SendOutcome::would_wait;
    if (const auto outcome = send_batch(to, by, datagram_bytes, now); outcome != SendOutcome::sent)
      return outcome;
  } while (!fragments.done());
  return SendOutcome::sent;
}

/// What cannot leave at once is for the sending thread.
void VariantSender::send_now(Channel& channel, const Channel::Piece& piece, Clock::time_point now) {
  Destination& to = channel.destination();
  cut_for_ = 0;
  bool must_look = true;
  if (send_at_once(piece.body(), to, to.connection(), now) == SendOutcome::sent) {
    must_look = channel.finished(piece, now);
  } else {
    channel.put_back(piece);
  }
  if (must_look) side_->sender.look_again();
}

bool VariantSender::encode(const Group& group, const core::SampleBuffer& sample, Job& job) const {
  assert(sample.mask.contains(group.plan.mask()));
  const detail::SampleState source = core::state_of(sample, type_.slots());
  if (!job.projection.project(source, group.plan)) return false;
  if (job.projection.bytes() > side_->max_sample_bytes) {
    side_->over_limit.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  describe(group, sample, job);
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  return true;
}

/// All but how long the body is.
void VariantSender::describe(const Group& group, const core::SampleBuffer& sample, Job& job) const {
  job.mask = group.wire;
  job.sequence = sample.sequence;
  job.whole_bytes = sample.whole_bytes;
  job.first.label = {writer_, static_cast<std::uint32_t>(sample.sequence), group.wire->variant};
  job.first.flags = group.wire->words.empty() ? std::uint8_t{0} : mask_words_follow;
  if (group.multicast != nullptr) job.first.flags |= merged_masks;
  if (group.late_reader != 0) job.first.flags |= history_follows;
  job.first.history.reader = group.late_reader;
  job.first.mask = group.wire->mask;
  job.first.stamp_ns = sample.source_stamp_ns;
}

/// `would_wait` where it is for the sending thread: the body is not small, or the send buffer is full.
SendOutcome VariantSender::try_send(Lane& lane, Job& job) {
  Destination& to = lane.destination();
  const Clock::time_point now = Clock::now();
  if (job.is_pack()) {
    return may_send_now(to, job, now) ? send_at_once(job.body(), to, to.connection_after(lane.behind()), now)
                                      : SendOutcome::would_wait;
  }
  if (job.first.total > direct_bytes_max) return SendOutcome::would_wait;
  if ((job.first.flags & history_follows) != 0) lane.mark(job);
  if (!may_send_now(to, job, now)) return SendOutcome::would_wait;
  // Most destinations take datagrams of the same length: they are cut once.
  if (const std::size_t datagram_bytes = to.datagram_bytes(); datagram_bytes != cut_for_) {
    Fragmenter fragments(job.body(), datagram_bytes);
    fragments.next(batch_);
    cut_for_ = fragments.done() ? datagram_bytes : 0;
    if (!fragments.done()) return SendOutcome::would_wait;
  }
  if (batch_.datagrams() > to.datagrams_per_call()) return SendOutcome::would_wait;
  return send_batch(to, to.connection_after(lane.behind()), cut_for_, now);
}

/// There is room for more, as it were; otherwise the sending thread goes on when there is. What is sent
/// before the first report has to fit as a whole.
bool VariantSender::may_send_now(Destination& to, const Job& job, Clock::time_point now) {
  if (!tally_->limit.ready(true, now) || !side_->sender.limit().ready(true, now)) return false;
  const std::size_t room = to.room(Destination::Size::small, now);
  if (room == 0 || to.answers()) return room > 0;
  return job.first.bytes() + (job.is_pack() ? job.packed_bytes() : job.first.total) <= room;
}

/// `would_wait`, too, where it has to be cut again.
SendOutcome VariantSender::send_batch(Destination& to, Connection& by, std::size_t cut_for,
                                      Clock::time_point now) {
  const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
  const auto [batches, outcome, refused] = by.try_send({&batch, 1});
  if (refused) to.refused(now);
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
    tally_->limit.spend(batch_.bytes());
    side_->sender.limit().spend(batch_.bytes());
    to.sent(by, batch_.bytes(), batch_.datagrams(), now);
  } else if (outcome != SendOutcome::would_wait) {
    to.note(outcome);
    if (outcome == SendOutcome::too_long && to.datagram_bytes() < cut_for) return SendOutcome::would_wait;
  }
  return outcome;
}

/// False if an older sample had to go for it.
bool VariantSender::enqueue(const std::shared_ptr<Lane>& lane) {
  const Lane::Posted posted = lane->post(blank_);
  if (posted.was_idle) side_->sender.schedule(lane);
  if (posted.dropped_oldest) side_->over_limit.fetch_add(1, std::memory_order_relaxed);
  return !posted.dropped_oldest;
}

}  // namespace sft::udp
