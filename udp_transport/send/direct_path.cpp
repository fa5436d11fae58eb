#include "udp_transport/send/direct_path.h"

#include <algorithm>

#include "udp_transport/send/allowance.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

bool DirectPath::may_send(Destination& to, const Job& job, Time now) {
  if (!tally_->limit.ready(true, now) || !side_->sender.limit().ready(true, now)) return false;
  const std::size_t room = to.room(Destination::Size::small, now);
  if (room == 0 || to.window().answers()) return room > 0;
  return job.first.bytes() + (job.is_pack() ? job.packed_bytes() : job.first.total) <= room;
}

SendOutcome DirectPath::send(Lane& lane, Job& job) {
  Destination& to = lane.destination();
  const Time now = Clock::now();
  if (job.is_pack()) {
    return may_send(to, job, now) ? send_whole(job.body(), to, to.connection_after(lane.behind()), now)
                                  : SendOutcome::would_wait;
  }
  if (job.first.total > direct_bytes_max) return SendOutcome::would_wait;
  if ((job.first.flags & history_follows) != 0) lane.mark(job);
  if (!may_send(to, job, now)) return SendOutcome::would_wait;
  // Most destinations accept datagrams of the same length, so the sample is usually cut only once for all of
  // them.
  if (const std::size_t datagram_bytes = to.path().datagram_bytes(); datagram_bytes != cut_for_) {
    Fragmenter fragments(job.body(), datagram_bytes);
    fragments.next(batch_);
    cut_for_ = fragments.done() ? datagram_bytes : 0;
    if (!fragments.done()) return SendOutcome::would_wait;
  }
  if (batch_.datagrams() > to.datagrams_per_call()) return SendOutcome::would_wait;
  return send_batch(to, to.connection_after(lane.behind()), cut_for_, now);
}

Wake DirectPath::send(Channel& channel, const Channel::Piece& piece, Time now) {
  Destination& to = channel.destination();
  cut_for_ = 0;
  if (send_whole(piece.body(), to, to.connection(), now) == SendOutcome::sent)
    return channel.finished(piece, now);
  channel.put_back(piece);
  return Wake::look;
}

std::uint32_t DirectPath::send_some(const EncodedBody& body, Destination& to) {
  Connection& by = *to.bulk_in_use();
  const std::size_t cut_for = to.path().datagram_bytes();
  Fragmenter fragments(body, cut_for);
  while (!fragments.done()) {
    const Time now = Clock::now();
    const std::size_t allowed =
        allowance(to, tally_->limit, side_->sender.limit(), ResendWindow::Size::large, now);
    if (allowed == 0) break;
    Fragmenter next = fragments;
    next.next(batch_, std::min(allowed, to.window().batch_bytes()), to.datagrams_per_call());
    if (send_batch(to, by, cut_for, now) != SendOutcome::sent) break;
    fragments = next;
  }
  return fragments.offset();
}

/// Sends a small body by one system call, and a pack by one or more calls. Returns `would_wait` if the
/// sending thread has to send the body.
SendOutcome DirectPath::send_whole(const EncodedBody& body, Destination& to, Connection& by, Time now) {
  const std::size_t datagram_bytes = to.path().datagram_bytes();
  Fragmenter fragments(body, datagram_bytes);
  do {
    fragments.next(batch_, batch_bytes_max, body.packed ? to.datagrams_per_call() : batch_datagrams_max);
    if (!body.packed && (!fragments.done() || batch_.datagrams() > to.datagrams_per_call()))
      return SendOutcome::would_wait;
    if (const auto outcome = send_batch(to, by, datagram_bytes, now); outcome != SendOutcome::sent)
      return outcome;
  } while (!fragments.done());
  return SendOutcome::sent;
}

/// Sends the batch. Returns `would_wait` if the send buffer is full, or if the sample has to be cut again.
SendOutcome DirectPath::send_batch(Destination& to, Connection& by, std::size_t cut_for, Time now) {
  const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
  const auto [batches, outcome, refused] = by.try_send({&batch, 1});
  if (refused) to.refused(now);
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
    tally_->limit.spend(batch_.bytes());
    side_->sender.limit().spend(batch_.bytes());
    to.sent(by, batch_.bytes(), batch_.datagrams(), batch_.longest(), now);
  } else if (outcome != SendOutcome::would_wait) {
    to.note(outcome);
    if (outcome == SendOutcome::too_long && to.path().datagram_bytes() < cut_for)
      return SendOutcome::would_wait;
  }
  return outcome;
}

}  // namespace sft::udp
