// What the writers of one transport share.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "udp_transport/channel_directory.h"
#include "udp_transport/destination.h"
#include "udp_transport/sender.h"

namespace sft::udp {

/// Outlives the transport as long as a writer does.
struct SendSide {
  SendSide(std::unique_ptr<DatagramSender> io, const DestinationLimits& limits,
           std::uint64_t max_bytes_per_s = 0)
      : sender(std::move(io), max_bytes_per_s),
        destinations(limits, [this](const SocketAddress& to) { return sender.connect(to); }) {}

  Sender sender;
  DestinationDirectory destinations;
  ChannelRoster channels;
  std::uint16_t ack_port = 0;        ///< where this transport receives
  std::size_t max_sample_bytes = 0;  ///< of a body
  std::size_t queue_depth = 0;
  std::atomic<std::uint64_t> over_limit{0};
};

}  // namespace sft::udp
