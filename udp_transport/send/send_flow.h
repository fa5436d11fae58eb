// The present job of one lane, or of one of a channel's two queues, and the progress of sending it.
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
  /// Time when the flow's connection became full, if nothing was sent since.
  std::optional<Time> full_since{};
  std::optional<Time> stalled_since{};  ///< time when the flow stalled, if nothing was sent since
  bool waits_for_room = false;          ///< true if the lane's current job has no room in the lane's channel
  std::uint64_t behind = 0;  ///< the destination's position after the latest part of a large sample
  std::optional<Channel::Piece> piece{};  ///< the piece, which keeps the memory that the fragments refer to

  Destination& destination() const { return lane ? lane->destination() : channel->destination(); }
  WriterTally& tally() const { return lane ? lane->tally() : channel->tally(); }
  /// Returns the connection for the flow. A small sample overtakes large samples, unless it has to arrive
  /// behind one of them.
  Connection& connection() const {
    if (size == Size::large) return destination().bulk();
    return lane ? destination().connection_after(lane->behind()) : destination().connection();
  }
};

}  // namespace sft::udp
