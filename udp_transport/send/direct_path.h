// Sends samples at once, on the thread that publishes: small samples, and large ones from the program's
// memory.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/send/send_side.h"

namespace sft::udp {

/// An object is used by one thread only.
class DirectPath {
 public:
  using Time = std::chrono::steady_clock::time_point;

  DirectPath(std::shared_ptr<SendSide> side, std::shared_ptr<WriterTally> tally)
      : side_(std::move(side)), tally_(std::move(tally)) {}

  /// Called before another sample is sent. That sample has to be cut first.
  void begin_sample() { cut_for_ = 0; }

  /// Returns true if there is room for more at the destination. Otherwise the sending thread continues once
  /// there is room. Before the first report of the destination the whole job has to fit.
  bool may_send(Destination& to, const Job& job, Time now);
  /// Sends a job of that lane. Returns `would_wait` if the sending thread has to send it, because the body
  /// is not small or the send buffer is full.
  SendOutcome send(Lane& lane, Job& job);
  /// Sends a piece of that channel. If it cannot leave at once, the result wakes the sending thread, which
  /// sends it.
  Wake send(Channel& channel, const Channel::Piece& piece, Time now);
  /// Sends as much of a large body as may be sent now. Returns the number of bytes that were sent.
  std::uint32_t send_some(const EncodedBody& body, Destination& to);

 private:
  SendOutcome send_whole(const EncodedBody& body, Destination& to, Connection& by, Time now);
  SendOutcome send_batch(Destination& to, Connection& by, std::size_t cut_for, Time now);

  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  Batch batch_;  ///< the datagrams of the present sample
  /// The datagram length for which the batch was cut; 0: the batch has no datagrams of the present sample.
  std::size_t cut_for_ = 0;
};

}  // namespace sft::udp
