// Sends samples at once, on the publisher's thread. These are small samples, and large samples from the
// program's memory.
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

/// An object must be used by only one thread.
class DirectPath {
 public:
  using Time = std::chrono::steady_clock::time_point;

  DirectPath(std::shared_ptr<SendSide> side, std::shared_ptr<WriterTally> tally)
      : side_(std::move(side)), tally_(std::move(tally)) {}

  /// Must be called before a new sample is sent. The sample is then cut into datagrams by the next send.
  void begin_sample() { cut_for_ = 0; }

  /// Returns true if the rate limits and the window of the destination allow more bytes now. If they do not,
  /// the sending thread has to send the job later. Before the first report of the destination, the window
  /// has to allow the whole job.
  bool may_send(Destination& to, const Job& job, Time now);
  /// Sends a job of that lane. Returns `would_wait` if the sending thread has to send the job, because the
  /// body is not small or the send buffer is full.
  SendOutcome send(Lane& lane, Job& job);
  /// Sends a piece of that channel. If it cannot be sent at once, the piece is put back into the channel.
  /// The caller must wake the sending thread as the result says.
  Wake send(Channel& channel, const Channel::Piece& piece, Time now);
  /// Sends as much of a large body as may be sent now. Returns the number of sent bytes of the body.
  std::uint32_t send_some(const EncodedBody& body, Destination& to);

 private:
  SendOutcome send_whole(const EncodedBody& body, Destination& to, Connection& by, Time now);
  SendOutcome send_batch(Destination& to, Connection& by, std::size_t cut_for, Time now);

  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  Batch batch_;  ///< the datagrams of the sample that is being sent
  /// The datagram length for which the batch was cut; 0: the batch does not have the datagrams of the whole
  /// sample.
  std::size_t cut_for_ = 0;
};

}  // namespace sft::udp
