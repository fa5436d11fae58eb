#include "udp_transport/sender.h"

#include <sys/prctl.h>

#include <algorithm>
#include <utility>

#include "udp_transport/named_thread.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
constexpr unsigned long timer_slack_ns = 1000;  // the default would add 50 us to pauses that may be as short
}  // namespace

Sender::Sender(std::unique_ptr<DatagramSender> io) : io_(std::move(io)) {}

Sender::~Sender() { stop(); }

Result<void> Sender::start(const std::string& thread_name) {
  Result<std::thread> started = start_thread(thread_name, [this] { run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void Sender::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_.store(true, std::memory_order_release);
  }
  io_->stop();
  work_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Sender::schedule(std::shared_ptr<Outbox> outbox) {
  {
    const std::scoped_lock lock(mutex_);
    scheduled_.push_back(std::move(outbox));
  }
  work_.notify_one();
}

void Sender::run() {
  ::prctl(PR_SET_TIMERSLACK, timer_slack_ns);
  while (await_work()) {
    wake_at_ = Time::max();
    for (Transfer& transfer : transfers_) {
      if (advance(transfer)) begin(transfer);
    }
    const auto idle = std::partition(transfers_.begin(), transfers_.end(),
                                     [](const Transfer& transfer) { return transfer.outbox != nullptr; });
    spare_.insert(spare_.end(), std::make_move_iterator(idle), std::make_move_iterator(transfers_.end()));
    transfers_.erase(idle, transfers_.end());
  }
  transfers_.clear();
  io_->finish();
}

/// Waits until a flow may go on or something new was scheduled, and takes that over. False at the end.
bool Sender::await_work() {
  std::unique_lock lock(mutex_);
  const auto disturbed = [this] { return stopped() || !scheduled_.empty(); };
  if (transfers_.empty()) {
    work_.wait(lock, disturbed);
  } else if (wake_at_ > Clock::now()) {
    work_.wait_until(lock, wake_at_, disturbed);
  }
  if (stopped()) return false;
  taken_.swap(scheduled_);
  lock.unlock();
  for (std::shared_ptr<Outbox>& outbox : taken_) {
    if (spare_.empty()) spare_.emplace_back();
    transfers_.push_back(std::move(spare_.back()));
    spare_.pop_back();
    transfers_.back().outbox = std::move(outbox);
    begin(transfers_.back());
  }
  taken_.clear();
  return true;
}

/// Takes the next job of the transfer's outbox, or leaves it without one where the outbox is empty.
void Sender::begin(Transfer& transfer) {
  const Job* job = transfer.outbox->next();
  if (job == nullptr) {
    transfer.outbox.reset();
    return;
  }
  wake_at_ = {};
  const auto& destinations = job->audience->destinations;
  for (std::size_t i = job->next_destination; i < destinations.size(); ++i) {
    transfer.flows.push_back(
        {destinations[i].get(), Fragmenter(job->body(), destinations[i]->datagram_bytes())});
  }
}

/// Sends what each flow may send now. True if the job is done.
bool Sender::advance(Transfer& transfer) {
  std::erase_if(transfer.flows, [&](Flow& flow) { return advance(flow, transfer.outbox->tally()); });
  if (!transfer.flows.empty()) return false;
  transfer.outbox->done();
  return true;
}

/// True if the flow has come to its end, one way or the other.
bool Sender::advance(Flow& flow, WriterTally& tally) {
  Destination& to = *flow.destination;
  const Time now = Clock::now();
  to.pacer().set_burst(to.burst_bytes());
  std::size_t bytes = 0;
  std::size_t n = 0;
  while (n < batches_per_call && !flow.fragments.done() && to.pacer().ready(now)) {
    flow.fragments.next(batches_[n], to.burst_bytes(), to.datagrams_per_call());
    to.pacer().spend(batches_[n].bytes());
    bytes += batches_[n].bytes();
    ++n;
  }
  const SendOutcome outcome = n == 0 ? SendOutcome::sent : send(to, n);
  if (outcome != SendOutcome::sent) {
    to.note(outcome);
    tally.dropped.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  tally.bytes_sent.fetch_add(bytes, std::memory_order_relaxed);
  wake_at_ = std::min(wake_at_, to.pacer().next_ready(now));
  return flow.fragments.done();
}

SendOutcome Sender::send(Destination& destination, std::size_t batches) {
  std::array<OutgoingBatch, batches_per_call> outgoing;
  for (std::size_t i = 0; i < batches; ++i) {
    outgoing[i] = {destination.address(), batches_[i].parts(), batches_[i].segment_bytes()};
  }
  return io_->send({outgoing.data(), batches});
}

}  // namespace sft::udp
