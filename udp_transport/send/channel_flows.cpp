#include "udp_transport/send/channel_flows.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
using Size = SendFlow::Size;
constexpr std::size_t small_samples_per_turn = 64;
}  // namespace

void ChannelFlows::add(std::shared_ptr<Channel> channel) {
  SendFlow small{.channel = channel, .size = Size::small};
  SendFlow large{.channel = channel, .size = Size::large};
  attended_.push_back({std::move(channel), std::move(small), std::move(large)});
}

void ChannelFlows::send_small() {
  for (Attended& attended : attended_) {
    advance(attended.small);
    look_after(attended);
  }
}

void ChannelFlows::send_large(std::size_t which) {
  if (attended_[which].channel) advance(attended_[which].large);
}

void ChannelFlows::forget_resting() {
  std::erase_if(attended_, [](const Attended& attended) { return attended.channel == nullptr; });
}

/// Sends samples of the flow. For small samples, continues until none is left, no more may be sent, or the
/// maximum number per turn is reached. For large samples, ends after one sample.
void ChannelFlows::advance(SendFlow& flow) {
  for (std::size_t samples = 0; samples < small_samples_per_turn; ++samples) {
    if (!flow.piece) {
      flow.piece = flow.channel->next(flow.size);
      if (!flow.piece) return;
      flow.full_since.reset();
      flow.fragments.emplace(flow.piece->body(), flow.destination().path().datagram_bytes(),
                             flow.piece->range);
    }
    if (FlowSender::is_under_way(sender_.send_some(flow))) return;
    // A datagram that could not be sent counts as sent, too, because the receiver will request it again.
    static_cast<void>(flow.channel->finished(*flow.piece, Clock::now()));
    flow.piece.reset();
    flow.fragments.reset();
    if (flow.size == Size::large) break;
  }
  round_.at_once();
}

void ChannelFlows::look_after(Attended& attended) {
  const Channel::Care care = attended.channel->look_after();
  if (care.heartbeat) send(*care.heartbeat, attended);
  round_.by(care.next_look);
  if (!care.at_rest) return;
  attended.channel.reset();
  round_.at_once();  // the channel, and the samples that it keeps, are released in the next round
}

/// Sends a heartbeat by a connection that cannot overtake the samples that it reports.
void ChannelFlows::send(const Heartbeat& heartbeat, const Attended& attended) {
  std::array<std::byte, heartbeat_bytes> bytes;
  encode(heartbeat, bytes.data());
  Destination& to = attended.channel->destination();
  if (!to.takes_control(Clock::now())) return;
  const SendOutcome outcome =
      send_one(to.connection_after(std::max(attended.large.behind, attended.channel->behind())), bytes);
  if (outcome == SendOutcome::sent) {
    attended.channel->tally().bytes_sent.fetch_add(bytes.size(), std::memory_order_relaxed);
  } else {
    to.note(outcome);
  }
}

}  // namespace sft::udp
