#include "udp_transport/variant_sender.h"

#include <cassert>
#include <chrono>
#include <new>
#include <utility>

namespace sft::udp {

VariantSender::VariantSender(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
                             std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : writer_(static_cast<std::uint32_t>(spec.id)),
      type_(*spec.type),
      side_(std::move(side)),
      tally_(std::move(tally)),
      jobs_(std::move(jobs)) {}

std::size_t VariantSender::send(const Group& group, const core::SampleHandle& sample) noexcept try {
  if (!prepare(group, *sample)) {
    group.tally->dropped();
    return group.lanes.size();
  }
  const std::uint32_t bytes = blank_->first.total;
  const std::size_t missed =
      group.multicast == nullptr ? send_alone(group, sample) : send_together(group, sample);
  group.tally->sent(bytes, sample->whole_bytes);
  release_blank();
  return missed;
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  group.tally->dropped();
  blank_ = {};
  blank_kept_ = false;
  return group.lanes.size();
}

/// For what is sent later. A channel that has the job counts what it holds: it has a copy of the body.
void VariantSender::hold(const core::SampleHandle& sample) {
  if (!blank_->sample && !blank_kept_) blank_->sample = sample;
}

/// Encodes it into the next job.
bool VariantSender::prepare(const Group& group, const core::SampleBuffer& sample) {
  if (!blank_) blank_ = jobs_->take();
  Job& job = *blank_;
  if (!encode(group, sample, job)) return false;
  if (group.gate != nullptr) {
    job.first.flags |= rate_follows;
    job.first.rate = {group.gate->min_period_us(), group.gate->ordinal()};
  }
  cut_for_ = 0;
  return true;
}

void VariantSender::release_blank() {
  if (std::exchange(blank_kept_, false) || blank_->sample) blank_ = {};
}

std::size_t VariantSender::send_alone(const Group& group, const core::SampleHandle& sample) {
  std::size_t missed = 0;
  for (std::size_t i = 0; i < group.lanes.size(); ++i) missed += send_alone(group, i, sample) ? 0 : 1;
  return missed;
}

bool VariantSender::send_alone(const Group& group, std::size_t place, const core::SampleHandle& sample) {
  Job& job = *blank_;
  const std::shared_ptr<Lane>& lane = group.lanes[place];
  if (group.channels[place] != nullptr) return send_reliably(lane, group.channels[place], sample);
  const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::sent) return true;
  if (outcome == SendOutcome::would_wait) {
    hold(sample);
    return enqueue(lane);
  }
  lane->losses()->lost(job.first.total, sample->whole_bytes);
  return false;
}

/// Each reliable member keeps it in its channel, for repairs, or to send it itself while the member does not
/// hear the group or has no room. Copies for others of those that do not hear it have no mark of the group.
std::size_t VariantSender::send_together(const Group& group, const core::SampleHandle& sample) {
  MulticastGroup& together = *group.multicast;
  const std::uint64_t ordinal = together.next_ordinal(std::chrono::steady_clock::now());
  const bool is_small = blank_->first.total <= direct_bytes_max;
  const bool has_room = together.lane()->has_room() && !together.broken();
  std::size_t missed = 0;
  if (!is_small) hold(sample);
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    if (group.channels[i] == nullptr) continue;
    if (is_small && !std::exchange(blank_kept_, true)) blank_->copy_body();
    missed += keep_together(group, i, ordinal, has_room) ? 0 : 1;
  }
  const MulticastGroup::BestEffort others = together.best_effort();
  if (has_room || others.some_hear) {
    // The job is shared by now, and what it says of itself is for the group alone.
    blank_->first.flags |= group_follows;
    blank_->first.group = {together.name().number, static_cast<std::uint32_t>(sample->sequence >> 32),
                           ordinal};
    missed += send_to_group(group, sample) ? 0 : 1;
  }
  if (!others.some_do_not) return missed;
  release_blank();
  if (!prepare(group, *sample)) return missed;
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    if (group.channels[i] == nullptr && !together.hears(i)) missed += send_alone(group, i, sample) ? 0 : 1;
  }
  return missed;
}

bool VariantSender::keep_together(const Group& group, std::size_t place, std::uint64_t ordinal,
                                  bool has_room) {
  MulticastGroup& together = *group.multicast;
  const std::shared_ptr<Channel>& channel = group.channels[place];
  const bool elsewhere = has_room && together.hears(place);
  const Channel::Posted posted = channel->post_shared(blank_, blank_->first, elsewhere);
  together.placed(place, ordinal, posted.kept.ordinal);
  return note(posted, channel, *group.lanes[place]);
}

bool VariantSender::send_to_group(const Group& group, const core::SampleHandle& sample) {
  MulticastGroup& together = *group.multicast;
  const std::shared_ptr<Lane>& lane = together.lane();
  Job& job = *blank_;
  if (together.broken()) {
    together.left(job, false);  // those who would have heard it ask for it
    return true;
  }
  const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::would_wait) {
    hold(sample);
    return enqueue(lane);
  }
  together.left(job, outcome != SendOutcome::sent);
  return outcome == SendOutcome::sent;
}

/// A late reader's lane holds it back while its history goes first. False if an older sample had to go for
/// it.
bool VariantSender::send_reliably(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel,
                                  const core::SampleHandle& sample) {
  Job& job = *blank_;
  const bool is_small = job.first.total <= direct_bytes_max;
  if (lane->is_late() && !lane->idle()) {
    hold(sample);
    return enqueue(lane);
  }
  if (lane->is_late()) lane->mark(job);
  if (is_small && !std::exchange(blank_kept_, true)) job.copy_body();
  if (!is_small) hold(sample);
  const Channel::Posted posted = channel->post(blank_, job.first, is_small);
  if (posted.piece) send_now(*channel, *posted.piece);
  return note(posted, channel, *lane);
}

/// Wakes who has to look after it. False if an older sample had to go for it.
bool VariantSender::note(const Channel::Posted& posted, const std::shared_ptr<Channel>& channel, Lane& lane) {
  if (posted.was_at_rest) {
    side_->sender.schedule(channel);
  } else if (posted.waits) {
    side_->sender.look_again();
  }
  const ResendWindow::Kept& kept = posted.kept;
  for (std::size_t i = 0; i < kept.dropped; ++i)
    lane.losses()->lost(i == 0 ? kept.dropped_bytes : 0, i == 0 ? kept.dropped_whole_bytes : 0);
  side_->over_limit.fetch_add(kept.dropped, std::memory_order_relaxed);
  return kept.dropped == 0;
}

/// What cannot leave at once is for the sending thread.
void VariantSender::send_now(Channel& channel, const Channel::Piece& piece) {
  Destination& to = channel.destination();
  Fragmenter fragments(piece.job->body(piece.first), to.datagram_bytes());
  fragments.next(batch_);
  cut_for_ = 0;
  SendOutcome outcome = SendOutcome::would_wait;
  if (fragments.done() && batch_.datagrams() <= to.datagrams_per_call()) {
    const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
    outcome = to.connection().try_send({&batch, 1}).outcome;
  }
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
    return channel.finished(piece);
  }
  if (outcome != SendOutcome::would_wait) to.note(outcome);
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
  job.mask = group.wire;
  job.sequence = sample.sequence;
  job.whole_bytes = sample.whole_bytes;
  job.first.label = {writer_, static_cast<std::uint32_t>(sample.sequence), group.wire->variant};
  job.first.flags = group.wire->words.empty() ? std::uint8_t{0} : mask_words_follow;
  if (group.multicast != nullptr) job.first.flags |= merged_masks;
  if (group.late_reader != 0) job.first.flags |= history_follows;
  job.first.history.reader = group.late_reader;
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  job.first.mask = group.wire->mask;
  job.first.stamp_ns = sample.source_stamp_ns;
  return true;
}

/// `would_wait` where it is for the sending thread: the body is not small, or the send buffer is full.
SendOutcome VariantSender::try_send(Lane& lane, Job& job) {
  if (job.first.total > direct_bytes_max) return SendOutcome::would_wait;
  if ((job.first.flags & history_follows) != 0) lane.mark(job);
  Destination& to = lane.destination();
  // Most destinations take datagrams of the same length: they are cut once.
  if (const std::size_t datagram_bytes = to.datagram_bytes(); datagram_bytes != cut_for_) {
    Fragmenter fragments(job.body(), datagram_bytes);
    fragments.next(batch_);
    cut_for_ = fragments.done() ? datagram_bytes : 0;
    if (!fragments.done()) return SendOutcome::would_wait;
  }
  if (batch_.datagrams() > to.datagrams_per_call()) return SendOutcome::would_wait;
  const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
  const SendOutcome outcome = to.connection().try_send({&batch, 1}).outcome;
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
  } else if (outcome != SendOutcome::would_wait) {
    to.note(outcome);
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
