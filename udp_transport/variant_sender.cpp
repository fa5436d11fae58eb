#include "udp_transport/variant_sender.h"

#include <cassert>
#include <new>
#include <utility>

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

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
  cut_for_ = 0;
  std::size_t missed = 0;
  for (std::size_t i = 0; i < group.lanes.size(); ++i) {
    const std::shared_ptr<Lane>& lane = group.lanes[i];
    if (group.channels[i] != nullptr) {
      missed += send_reliably(lane, group.channels[i], sample) ? 0 : 1;
      continue;
    }
    const SendOutcome outcome = lane->idle() ? try_send(*lane, job) : SendOutcome::would_wait;
    if (outcome == SendOutcome::would_wait) {
      if (!job.sample) job.sample = sample;
      missed += enqueue(lane) ? 0 : 1;
    } else if (outcome != SendOutcome::sent) {
      lane->losses()->lost(job.first.total, sample->whole_bytes);
      ++missed;
    }
  }
  group.tally->sent(job.first.total, sample->whole_bytes);
  if (job.sample || std::exchange(blank_kept_, false)) blank_ = {};
  return missed;
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  group.tally->dropped();
  blank_ = {};
  blank_kept_ = false;
  return group.lanes.size();
}

/// A late reader's lane holds it back while its history goes first. False if an older sample had to go for
/// it.
bool VariantSender::send_reliably(const std::shared_ptr<Lane>& lane, const std::shared_ptr<Channel>& channel,
                                  const core::SampleHandle& sample) {
  Job& job = *blank_;
  const bool is_small = job.first.total <= direct_bytes_max;
  if (lane->is_late() && !lane->idle()) {
    if (!job.sample) job.sample = sample;
    return enqueue(lane);
  }
  if (lane->is_late()) lane->mark(job);
  if (is_small && !std::exchange(blank_kept_, true)) job.copy_body();
  if (!is_small) job.sample = sample;
  const bool at_once = is_small && may_send_now(channel->destination(), Clock::now());
  const Channel::Posted posted = channel->post(blank_, job.first, at_once);
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
    outcome = send_batch(to, to.connection(), Clock::now());
  }
  if (outcome == SendOutcome::sent) return channel.finished(piece);
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
  const Clock::time_point now = Clock::now();
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
