#include "udp_transport/send/flow_sender.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <thread>

#include "udp_transport/send/allowance.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

void FlowSender::listen() {
  // The number per call is limited, because attackers may send more datagrams than can be handled.
  constexpr std::size_t answers_at_once = 64;
  std::array<std::byte, datagram_bytes_min> answer;
  for (std::size_t i = 0; i < answers_at_once; ++i) {
    const DatagramSender::Answer came = io_.take_answer(answer);
    if (came.bytes == 0) return;
    const std::span<const std::byte> datagram = std::span(answer).first(came.bytes);
    if (hear_ && hear_(datagram, came.from, std::chrono::steady_clock::now()) != Wake::none) round_.at_once();
  }
}

FlowSender::Progress FlowSender::send_some(SendFlow& flow) {
  Progress progress = Progress::some;
  for (int calls = 0; progress == Progress::some && calls < calls_per_turn; ++calls) {
    if (flow.size == SendFlow::Size::large && local_turns_.is_due(std::chrono::steady_clock::now()))
      std::this_thread::yield();
    if (calls > 0) listen();
    progress = send_a_few(flow, std::chrono::steady_clock::now());
  }
  if (progress == Progress::some) round_.at_once();
  return progress;
}

FlowSender::Progress FlowSender::send_a_few(SendFlow& flow, Time now) {
  Destination& to = flow.destination();
  Connection& by = flow.connection();
  if (by.full()) return wait_for_room(flow, by, now);
  const std::size_t cut = cut_batches(flow, now);
  if (cut == 0) return flow.fragments->done() ? Progress::whole : Progress::none;
  const Connection::Sent sent = by.try_send({outgoing_.data(), cut});
  if (sent.refused) to.refused(now);
  if (sent.batches > 0) {
    account_for(flow, by, sent.batches, now);
    flow.fragments = rest_[sent.batches - 1];
    flow.full_since.reset();
  }
  if (sent.outcome == SendOutcome::would_wait) return wait_for_room(flow, by, now);
  if (sent.outcome != SendOutcome::sent) {
    const std::size_t refused = to.path().datagram_bytes();
    to.note(sent.outcome);
    if (sent.outcome != SendOutcome::too_long || to.path().datagram_bytes() >= refused) return Progress::lost;
    flow.fragments->set_datagram_bytes(to.path().datagram_bytes());
    return Progress::some;
  }
  return flow.fragments->done() ? Progress::whole : Progress::some;
}

void FlowSender::account_for(SendFlow& flow, Connection& by, std::size_t batches, Time now) {
  std::size_t bytes = 0, datagrams = 0, longest = 0;
  for (const Batch& batch : std::span(batches_).first(batches)) {
    bytes += batch.bytes();
    datagrams += batch.datagrams();
    longest = std::max(longest, batch.longest());
  }
  flow.tally().bytes_sent.fetch_add(bytes, std::memory_order_relaxed);
  flow.tally().limit.spend(bytes);
  limit_.spend(bytes);
  flow.destination().sent(by, bytes, datagrams, longest, now);
  if (flow.size == SendFlow::Size::large) flow.behind = flow.destination().window().position();
}

/// Schedules the next round for the time at which data of the flow may be sent again. Called if no byte of
/// the flow may be sent now.
void FlowSender::wait_for_allowance(SendFlow& flow, Time now) {
  const bool small = flow.size == SendFlow::Size::small;
  for (RateLimit* limit : {&flow.tally().limit, &limit_}) {
    if (limit->ready(small, now)) continue;
    round_.by(limit->next_ready(small, now));
    return;
  }
  flow.destination().mark(now);
  round_.by(flow.destination().window().next_ready(now));
}

/// Cuts as many batches of the flow as may be sent by one system call now. Returns the number of batches.
std::size_t FlowSender::cut_batches(SendFlow& flow, Time now) {
  Destination& to = flow.destination();
  Fragmenter fragments = *flow.fragments;
  const std::size_t allowed = allowance(to, flow.tally().limit, limit_, flow.size, now);
  if (allowed == 0) wait_for_allowance(flow, now);
  const std::size_t bytes_max = std::min(allowed, to.window().batch_bytes());
  const std::size_t call_bytes = std::min(allowed, bytes_per_call);
  std::size_t n = 0;
  for (std::size_t cut = 0; n < batches_per_call && !fragments.done() && cut < call_bytes; ++n) {
    fragments.next(batches_[n], bytes_max, to.datagrams_per_call());
    // The receiver has not answered, and not even one datagram is allowed.
    if (batches_[n].bytes() > allowed && !to.window().answers()) {
      wait_for_allowance(flow, now);
      break;
    }
    cut += socket_bytes(batches_[n].bytes(), batches_[n].datagrams());
    outgoing_[n] = {batches_[n].parts(), batches_[n].segment_bytes()};
    rest_[n] = fragments;
  }
  return n;
}

FlowSender::Progress FlowSender::wait_for_room(SendFlow& flow, Connection& by, Time now) {
  if (!flow.full_since) flow.full_since = now;
  const Time at_most = *flow.full_since + timeout;
  if (now >= at_most) return Progress::lost;
  by.wait_for_room();
  round_.by(at_most);
  return Progress::none;
}

}  // namespace sft::udp
