#include "udp_transport/send/lane_flows.h"

#include <algorithm>
#include <chrono>

namespace sft::udp {

namespace {
using Progress = FlowSender::Progress;
using Size = SendFlow::Size;

/// The maximum time for which the flow of a multicast group waits until an older sample to one of its
/// members alone was sent.
constexpr std::chrono::milliseconds member_stalls_max{10};

/// Returns true if the job of `one` is older. REQUIRES: both flows have a job of the same writer.
bool is_older(const SendFlow& one, const SendFlow& other) {
  const auto sequence = [](const SendFlow& flow) { return flow.lane->current()->first.label.sequence; };
  return static_cast<std::int32_t>(sequence(one) - sequence(other)) < 0;
}
}  // namespace

void LaneFlows::send_small() {
  for (SendFlow& flow : flows_) {
    if (flow.lane->closed()) flow.fragments.reset();
    if (!flow.fragments && !begin(flow)) flow.lane.reset();
  }
  for (SendFlow& flow : flows_) {
    if (flow.lane && flow.fragments && flow.size == Size::small) advance(flow);
  }
}

void LaneFlows::send_large(std::size_t which) {
  SendFlow& flow = flows_[which];
  if (flow.lane && flow.fragments && flow.size == Size::large) advance(flow);
}

void LaneFlows::forget_idle() {
  std::erase_if(flows_, [](const SendFlow& flow) { return flow.lane == nullptr; });
}

/// Takes the next job of the flow's lane. Returns false if the lane has no job.
bool LaneFlows::begin(SendFlow& flow) {
  flow.fragments.reset();
  flow.full_since.reset();
  flow.stalled_since.reset();
  if (flow.lane->channel() != nullptr) return pass_on(flow);
  const Job* job = flow.lane->next();
  if (job == nullptr) return false;
  flow.size = KeptSamples::size_of(job->first.total);
  flow.fragments.emplace(job->body(), flow.lane->destination().path().datagram_bytes(),
                         BodyRange{job->sent_bytes});
  return true;
}

/// Passes the history of a late reader, and then the later jobs of the lane, to the lane's channel. Stops
/// while the channel is full, so that it does not give up samples for jobs that can wait in the lane.
/// Returns false if no job is left.
bool LaneFlows::pass_on(SendFlow& flow) {
  Lane& lane = *flow.lane;
  if (lane.closed()) flow.waits_for_room = false;
  while (flow.waits_for_room || lane.next() != nullptr) {
    const JobHandle& job = lane.current();
    flow.waits_for_room = !lane.channel()->has_room_or_waits(*job);
    if (flow.waits_for_room) return true;
    const Channel::Posted posted = lane.channel()->post(job, job->first, false);
    lane.passed_on(posted.kept.ordinal);
    if (posted.wake == Wake::schedule) scheduled_.add(lane.shared_channel());
    round_.at_once();
    lane.losses()->lost(posted.kept.dropped_bytes, posted.kept.dropped_whole_bytes, posted.kept.dropped);
  }
  return false;
}

/// Sends as much of the flow as may be sent now, and takes its next job when the present job is done.
void LaneFlows::advance(SendFlow& flow) {
  if (const SendFlow* other = holder_of(flow)) return note_stall(flow, other->stalled_since);
  const Progress progress = sender_.send_some(flow);
  if (progress != Progress::none) {
    flow.stalled_since.reset();
  } else if (!flow.stalled_since) {
    note_stall(flow, SendFlow::Clock::now());
  }
  if (FlowSender::is_under_way(progress)) return;
  if (progress == Progress::lost) flow.lane->lose_current();
  if (flow.size == Size::large) flow.lane->stay_behind(flow.behind);
  round_.at_once();
  if (!begin(flow)) flow.lane.reset();
}

/// Notes that the flow has stalled at `since`, if it has. Schedules a round for the time at which flows of
/// multicast groups that wait for this flow may overtake it. If the flow waits for another flow, `since` is
/// the time when that other flow stalled.
void LaneFlows::note_stall(SendFlow& flow, std::optional<SendFlow::Time> since) {
  if (since && !flow.stalled_since) round_.by(*since + member_stalls_max);
  flow.stalled_since = since;
}

/// Returns a flow whose sample has to be sent before that of `flow`; null if there is none. Large samples of
/// one writer, with any masks, are sent to a destination one after another. So the first sample is whole
/// sooner, and a receiver assembles only a few samples at a time. The oldest one is sent first, because a
/// best-effort reader whose mask has just changed would lose an older sample that comes after a newer one.
/// Only the samples that a late reader gets from the history are older than samples that are for others.
/// Small samples may be sent between large ones. If a receiver gets one sample by a group or in a shared
/// copy, and another sample by another lane, the older sample is sent first.
const SendFlow* LaneFlows::holder_of(const SendFlow& flow) {
  if (flow.fragments->begun()) return nullptr;
  const Destination& to = flow.lane->destination();
  const auto holder = std::ranges::find_if(flows_, [&](const SendFlow& other) {
    if (!other.lane || !other.fragments || &other.lane->tally() != &flow.lane->tally()) return false;
    if (&other == &flow) return false;
    const bool older = is_older(other, flow);
    const bool goes_first = other.fragments->begun() || (older && !other.lane->is_late());
    if (&other.lane->destination() == &to && flow.size == Size::large && goes_first) return true;
    return older && other.lane->end().meets_merged(flow.lane->end()) && !may_pass(flow, other);
  });
  return holder == flows_.end() ? nullptr : &*holder;
}

/// Returns true if `flow`, which is the flow of a group, may overtake `other`. That is allowed if `other` is
/// a flow to one member that has stalled for member_stalls_max.
bool LaneFlows::may_pass(const SendFlow& flow, const SendFlow& other) {
  if (!flow.lane->end().is_group() || other.lane->end().is_group() || !other.stalled_since) return false;
  const SendFlow::Time at = *other.stalled_since + member_stalls_max;
  if (SendFlow::Clock::now() >= at) return true;
  round_.by(at);
  return false;
}

}  // namespace sft::udp
