#include "udp_transport/variant_sender.h"

#include <algorithm>
#include <cassert>
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
}  // namespace

VariantSender::VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                             std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : writer_(static_cast<std::uint32_t>(spec.id)),
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
  return distribute(group, sample);
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  group.tally->dropped();
  blank_ = {};
  blank_kept_ = false;
  return group.lanes.size();
}

/// The blank job. Where it is a pack there is no sample: it keeps all by itself.
std::size_t VariantSender::distribute(const Group& group, const core::SampleHandle& sample) {
  Job& job = *blank_;
  const std::size_t samples = job.samples();
  cut_for_ = 0;
  std::size_t missed = 0;
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    const std::shared_ptr<Lane>& lane = group.lanes[i];
    if (group.channels[i] != nullptr) {
      missed += send_reliably(lane, group.channels[i], sample);
      continue;
    }
    const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
    if (outcome == SendOutcome::would_wait) {
      if (!job.sample) job.sample = sample;
      missed += enqueue(lane) ? 0 : samples;
      blank_kept_ = blank_kept_ || job.is_pack();
    } else if (outcome != SendOutcome::sent) {
      lane->losses()->lost(job.first.total, job.whole_bytes, samples);
      missed += samples;
    }
  }
  group.tally->sent(job.first.total, job.whole_bytes, samples);
  if (job.sample || std::exchange(blank_kept_, false)) blank_ = {};
  return missed;
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
  if (!group.packs) return Hold::unfit;
  if (!projected_) projected_ = jobs_->take();
  Projection& body = projected_->projection;
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
    if (held.pack->is_pack()) missed += send_pack(held);
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

/// A late reader's lane holds it back while its history goes first. Returns how many older samples had to go
/// for it.
std::size_t VariantSender::send_reliably(const std::shared_ptr<Lane>& lane,
                                         const std::shared_ptr<Channel>& channel,
                                         const core::SampleHandle& sample) {
  Job& job = *blank_;
  const std::size_t job_samples = job.samples();
  const bool is_small = job.is_pack() || job.first.total <= direct_bytes_max;
  if (lane->is_late() && !lane->idle()) {
    if (!job.sample) job.sample = sample;
    return enqueue(lane) ? 0 : 1;
  }
  if (lane->is_late()) lane->mark(job);
  if (is_small && !std::exchange(blank_kept_, true) && !job.is_pack()) job.copy_body();
  if (!is_small) job.sample = sample;
  const bool at_once = is_small && may_send_now(channel->destination(), Clock::now());
  const Channel::Posted posted =
      channel->post(blank_, job.first, at_once, patience_.count() == 0 ? nullptr : &patience_);
  if (posted.piece) send_now(*channel, *posted.piece);
  if (posted.was_at_rest) {
    side_->sender.schedule(channel);
  } else if (posted.waits) {
    side_->sender.look_again();
  }
  const ResendWindow::Kept& kept = posted.kept;
  for (std::size_t i = 0; i < kept.dropped; ++i)
    lane->losses()->lost(i == 0 ? kept.dropped_bytes : 0, i == 0 ? kept.dropped_whole_bytes : 0);
  side_->over_limit.fetch_add(kept.dropped, std::memory_order_relaxed);
  return std::min(kept.dropped, job_samples);
}

/// One call for a small body; a pack may take some. `would_wait` where the sending thread has to do it.
SendOutcome VariantSender::send_at_once(const EncodedBody& body, Destination& to, Connection& by) {
  Fragmenter fragments(body, to.datagram_bytes());
  do {
    fragments.next(batch_, batch_bytes_max, body.packed ? to.datagrams_per_call() : batch_datagrams_max);
    if (!body.packed && (!fragments.done() || batch_.datagrams() > to.datagrams_per_call()))
      return SendOutcome::would_wait;
    if (const auto outcome = send_batch(to, by, Clock::now()); outcome != SendOutcome::sent) return outcome;
  } while (!fragments.done());
  return SendOutcome::sent;
}

/// What cannot leave at once is for the sending thread.
void VariantSender::send_now(Channel& channel, const Channel::Piece& piece) {
  Destination& to = channel.destination();
  cut_for_ = 0;
  if (send_at_once(piece.body(), to, to.connection()) == SendOutcome::sent) return channel.finished(piece);
  channel.put_back(piece);
  side_->sender.look_again();
}

bool VariantSender::encode(const Group& group, const core::SampleBuffer& sample, Job& job) const {
  assert(sample.mask.contains(group.plan.mask()));
  const SampleState source = core::state_of(sample, type_.slots());
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
    return may_send_now(to, now) ? send_at_once(job.body(), to, to.connection_after(lane.behind()))
                                 : SendOutcome::would_wait;
  }
  if (job.first.total > direct_bytes_max) return SendOutcome::would_wait;
  if ((job.first.flags & history_follows) != 0) lane.mark(job);
  if (!may_send_now(to, now)) return SendOutcome::would_wait;
  // Most destinations take datagrams of the same length: they are cut once.
  if (const std::size_t datagram_bytes = to.datagram_bytes(); datagram_bytes != cut_for_) {
    Fragmenter fragments(job.body(), datagram_bytes);
    fragments.next(batch_);
    cut_for_ = fragments.done() ? datagram_bytes : 0;
    if (!fragments.done()) return SendOutcome::would_wait;
  }
  if (batch_.datagrams() > to.datagrams_per_call()) return SendOutcome::would_wait;
  return send_batch(to, to.connection_after(lane.behind()), now);
}

/// There is room for more, as it were; otherwise the sending thread goes on when there is.
bool VariantSender::may_send_now(Destination& to, Clock::time_point now) {
  return tally_->limit.ready(true, now) && side_->sender.limit().ready(true, now) &&
         to.room(Destination::Size::small, now) > 0;
}

SendOutcome VariantSender::send_batch(Destination& to, Connection& by, Clock::time_point now) {
  const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
  const SendOutcome outcome = by.try_send({&batch, 1}).outcome;
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
    tally_->limit.spend(batch_.bytes());
    side_->sender.limit().spend(batch_.bytes());
    to.sent(by, batch_.bytes(), batch_.datagrams(), now);
  } else if (outcome != SendOutcome::would_wait) {
    to.note(outcome);
    if (outcome == SendOutcome::too_long && to.datagram_bytes() < cut_for_) return SendOutcome::would_wait;
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
