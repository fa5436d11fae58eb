// The job that one lane, or one of a channel's two queues, is sending, and the progress of that.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

struct SendFlow {
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;
  using Size = ResendWindow::Size;

  std::shared_ptr<Lane> lane{};  ///< the lane of the flow; null: the flow belongs to the channel
  std::shared_ptr<Channel> channel{};
  Size size{};
  std::optional<Fragmenter> fragments{};
  /// The time when the flow's connection became full, if no data was sent since then.
  std::optional<Time> full_since{};
  std::optional<Time> stalled_since{};  ///< time when the flow stalled, if no data was sent since then
  bool waits_for_room = false;          ///< true if the lane's job waits because the lane's channel is full
  std::uint64_t behind = 0;  ///< the destination's position after the last sent part of a large sample
  /// The channel's piece; keeps the memory that `fragments` refers to.
  std::optional<Channel::Piece> piece{};

  Destination& destination() const { return lane ? lane->destination() : channel->destination(); }
  WriterTally& tally() const { return lane ? lane->tally() : channel->tally(); }
  /// Returns the connection for the flow. A small sample may overtake large samples, unless it has to arrive
  /// after one of them.
  Connection& connection() const {
    if (size == Size::large) return destination().bulk();
    return lane ? destination().connection_after(lane->behind()) : destination().connection();
  }
};

}  // namespace sft::udp
