#include "udp_transport/send/answers.h"

#include <memory>
#include <new>
#include <variant>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {

using Time = std::chrono::steady_clock::time_point;

/// If several members of the channel's multicast group request the same sample, removes its parts from the
/// ack, and sends the sample to the group again.
void hand_repairs_to_group(SendSide& side, Ack& ack, Time now) {
  const GroupRegistry::OfChannel in = side.groups.of_channel(ack.writer, ack.channel);
  if (in.group == nullptr) return;
  const Wake wake = in.group->take_over_repairs(in.member, ack, now);
  if (wake != Wake::none) side.sender.wake(wake, MulticastGroup::lane_of(in.group));
}

Wake reject(SendSide& side) {
  side.answers_rejected.fetch_add(1, std::memory_order_relaxed);
  return Wake::none;
}

/// Rejects an ack of a channel that the writer does not have, which the receiver may have followed by
/// mistake. Passes the ack to the writer's channels to that address, so that their samples carry the full
/// channel number from now on.
Wake hear_of_unknown_channel(SendSide& side, const Ack& ack, const SocketAddress& from) {
  Wake wake = reject(side);
  for (const std::shared_ptr<Channel>& channel : side.channels.find_at(ack.writer, from.ip))
    wake = strongest(wake, channel->hear(ack));
  return wake;
}

Wake hear(SendSide& side, const Ack& ack, const SocketAddress& from, Time now) {
  const std::shared_ptr<Channel> channel = side.channels.find(ack.writer, ack.channel);
  if (channel == nullptr) return hear_of_unknown_channel(side, ack, from);
  if (!channel->destination().path().is_at(from.ip)) return reject(side);
  channel->destination().lives(now);
  Ack alone = ack;
  if (ack.missing_count > 0) hand_repairs_to_group(side, alone, now);
  const Wake wake = channel->hear(alone);
  if (channel->went_wrong()) reject(side);
  return wake;
}

Wake hear(SendSide& side, const FlowReport& report, const SocketAddress& from, Time now) {
  const std::shared_ptr<Destination> to = side.destinations.of_flow(report.flow);
  if (to == nullptr) return reject(side);
  const Destination::Heard heard = to->hear(report, from.ip, now);
  if (!heard.accepted) return reject(side);
  return heard.goes_on ? Wake::look : Wake::none;
}

Wake hear(SendSide& side, const GroupReport& report, const SocketAddress& from, Time now) {
  const std::shared_ptr<MulticastGroup> group = side.groups.find(report.writer, report.group);
  const auto member = group == nullptr ? std::nullopt : group->member_named(report.member);
  const bool is_of_member = member && group->members()[*member].lane->destination().path().is_at(from.ip);
  if (!is_of_member) return reject(side);
  group->hear(report, now);
  return Wake::none;
}

}  // namespace

Wake hear_answer(SendSide& side, const Answer& answer, const SocketAddress& from, Time now) noexcept try {
  return std::visit([&](const auto& one) { return hear(side, one, from, now); }, answer);
} catch (const std::bad_alloc&) {  // the answer is dropped; a later answer will replace it
  return Wake::none;
}

Wake hear_answer(SendSide& side, std::span<const std::byte> datagram, const SocketAddress& from,
                 Time now) noexcept {
  const AnyDatagram any = decode(datagram);
  if (const Answer* answer = std::get_if<Answer>(&any)) return hear_answer(side, *answer, from, now);
  side.malformed_answers.fetch_add(1, std::memory_order_relaxed);
  return Wake::none;
}

}  // namespace sft::udp
