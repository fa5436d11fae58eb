#include "udp_transport/send/group_delivery.h"

#include <chrono>
#include <utility>

namespace sft::udp {

/// Sends the sample to all members of the group. The channel of each reliable member keeps the job, so that
/// lost parts can be sent again. The channel sends the whole sample if the member does not receive the
/// group, or if nothing can be sent to the group now. Best-effort members that do not receive the group get
/// separate copies without the fields of the group.
std::size_t GroupDelivery::send(const Audience& audience, const core::SampleHandle& sample,
                                const core::SampleHandle& body) {
  MulticastGroup& group = *audience.multicast;
  Job& job = unicast_.job();
  await_room(audience);
  const std::uint64_t ordinal = group.next_ordinal(std::chrono::steady_clock::now());
  const bool has_room = group.is_answered() && group.lane()->has_room() && !group.broken();
  unicast_.direct.begin_sample();
  audience.tally->sent(job.first.total, job.whole_bytes, 1);
  std::size_t missed = 0;
  unicast_.prepare_for_channels(audience, body);
  for (std::size_t i = 0; i < audience.lanes.size(); ++i) {
    if (audience.channels[i] != nullptr) missed += keep_for(audience, i, ordinal, has_room);
  }
  const MulticastGroup::BestEffort others = group.best_effort();
  const bool goes_to_group = has_room || others.some_hear;
  if (goes_to_group) {
    // The channels already share the job, and have their own headers. So only the group uses the job's
    // header.
    job.first.flags |= group_follows;
    job.first.group = {group.name().number, static_cast<std::uint32_t>(sample->sequence >> 32), ordinal};
    missed += send_to_group(audience, body) ? 0 : 1;
  }
  unicast_.release();
  return others.some_do_not ? missed + send_to_others(audience, sample, goes_to_group) : missed;
}

/// If the publisher waits for its readers, waits before any part of the sample is sent. It waits until the
/// channel of each reliable member can keep the sample without giving up an older one.
void GroupDelivery::await_room(const Audience& audience) {
  std::chrono::nanoseconds* const timeout = unicast_.timeout();
  if (timeout == nullptr) return;
  for (const std::shared_ptr<Channel>& channel : audience.channels) {
    if (channel != nullptr) channel->await_room(unicast_.job(), timeout);
  }
}

/// Sends the sample separately to the best-effort members that do not get it by the group. A member may
/// report at any time that it receives the group. That report is about an earlier datagram of the group, so
/// it counts only if this sample goes to the group, too.
std::size_t GroupDelivery::send_to_others(const Audience& audience, const core::SampleHandle& sample,
                                          bool goes_to_group) {
  Job& job = unicast_.begin();
  if (!encoder_.encode(audience, *sample, job)) return 0;
  SampleEncoder::number(audience, job);
  const core::SampleHandle parts = std::exchange(job.sample, {});
  unicast_.direct.begin_sample();
  std::size_t missed = 0;
  for (std::size_t i = 0; i < audience.lanes.size(); ++i) {
    const bool gets_it = goes_to_group && audience.multicast->hears(i);
    if (audience.channels[i] == nullptr && !gets_it)
      missed += unicast_.send(audience, i, parts ? parts : sample);
  }
  unicast_.release();
  return missed;
}

std::size_t GroupDelivery::keep_for(const Audience& audience, std::size_t member, std::uint64_t ordinal,
                                    bool has_room) {
  MulticastGroup& group = *audience.multicast;
  const std::shared_ptr<Channel>& channel = audience.channels[member];
  const bool elsewhere = has_room && group.hears(member);
  const Channel::Posted posted = channel->post_shared(unicast_.handle(), unicast_.job().first, elsewhere);
  group.placed(member, ordinal, posted.kept.ordinal);
  return unicast_.settle(posted, channel, *audience.lanes[member], 1);
}

/// Sends the sample to the group. Returns false if the group does not get the sample, or loses an older one
/// for it.
bool GroupDelivery::send_to_group(const Audience& audience, const core::SampleHandle& body) {
  MulticastGroup& group = *audience.multicast;
  const std::shared_ptr<Lane>& lane = group.lane();
  Job& job = unicast_.job();
  Sender& sender = side_->sender;
  if (!group.is_answered()) {  // no member has answered, or all of them are silent now
    sender.wake(group.note_departed(job, true));
    return false;
  }
  if (group.broken()) {
    // The sample is not sent now. The members that should have received it will request it.
    sender.wake(group.note_departed(job, false));
    return true;
  }
  const SendOutcome outcome = lane->is_clear() ? unicast_.direct.send(*lane, job) : SendOutcome::would_wait;
  if (outcome == SendOutcome::would_wait) {
    unicast_.keep(body);
    return unicast_.enqueue(MulticastGroup::lane_of(audience.multicast)) == 0;
  }
  sender.wake(group.note_departed(job, outcome != SendOutcome::sent));
  return outcome == SendOutcome::sent;
}

}  // namespace sft::udp
