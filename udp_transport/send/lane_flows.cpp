#include "udp_transport/send/lane_flows.h"

#include <algorithm>
#include <chrono>

namespace sft::udp {

namespace {
using Progress = FlowSender::Progress;
using Size = SendFlow::Size;

/// The longest time for which a group waits for an older sample to one of its members alone.
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

/// Takes the next job of the flow's lane. Returns false if there is none.
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

/// Hands the history of a late reader, and the jobs behind it, to the channel while there is room. The
/// channel need not give up samples for jobs that can wait here. Returns false if no job remains.
bool LaneFlows::pass_on(SendFlow& flow) {
  Lane& lane = *flow.lane;
  if (lane.closed()) flow.waits_for_room = false;
  while (flow.waits_for_room || lane.next() != nullptr) {
    const JobHandle& job = lane.current();
    flow.waits_for_room = !lane.channel()->has_room_or_tells(*job);
    if (flow.waits_for_room) return true;
    const Channel::Posted posted = lane.channel()->post(job, job->first, false);
    lane.passed_on(posted.kept.ordinal);
    if (posted.wake == Wake::schedule) scheduled_.add(lane.shared_channel());
    round_.at_once();
    lane.losses()->lost(posted.kept.dropped_bytes, posted.kept.dropped_whole_bytes, posted.kept.dropped);
  }
  return false;
}

/// Sends as much as the flow may send now, and takes its next job when the present one is done.
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

/// Schedules when groups that wait for the flow may pass it. A flow that waits for another flow counts as
/// stalled since the other one stalled.
void LaneFlows::note_stall(SendFlow& flow, std::optional<SendFlow::Time> since) {
  if (since && !flow.stalled_since) round_.by(*since + member_stalls_max);
  flow.stalled_since = since;
}

/// Returns a flow that has to be sent before this one; null if there is none. Large samples of one writer
/// go to a destination one after another, under any masks. So the first one is whole sooner, and a receiver
/// assembles only a few at a time. Small samples may pass between them. If a receiver gets one sample by a
/// group or in a shared copy, and another one by another lane, the older sample goes first.
const SendFlow* LaneFlows::holder_of(const SendFlow& flow) {
  if (flow.fragments->begun()) return nullptr;
  const Destination& to = flow.lane->destination();
  const auto holder = std::ranges::find_if(flows_, [&](const SendFlow& other) {
    if (!other.lane || !other.fragments || &other.lane->tally() != &flow.lane->tally()) return false;
    if (&other == &flow) return false;
    if (&other.lane->destination() == &to && flow.size == Size::large && other.fragments->begun())
      return true;
    return is_older(other, flow) && other.lane->end().meets_merged(flow.lane->end()) &&
           !may_pass(flow, other);
  });
  return holder == flows_.end() ? nullptr : &*holder;
}

/// Returns true if the group's flow `flow` may pass `other`, a flow to one of its members that has stalled
/// for long enough.
bool LaneFlows::may_pass(const SendFlow& flow, const SendFlow& other) {
  if (!flow.lane->end().is_group() || other.lane->end().is_group() || !other.stalled_since) return false;
  const SendFlow::Time at = *other.stalled_since + member_stalls_max;
  if (SendFlow::Clock::now() >= at) return true;
  round_.by(at);
  return false;
}

}  // namespace sft::udp
