#include "udp_transport/sender.h"

#include <sys/prctl.h>

#include <algorithm>
#include <utility>

#include "core/thread.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
constexpr unsigned long timer_slack_ns = 1000;  // the default would add 50 us to pauses that may be as short
/// A sample that waits longer for its connection is dropped: its memory is worth more elsewhere, and a
/// receiver that had a part of it has given up.
constexpr std::chrono::seconds patience{2};
constexpr std::size_t small_samples_per_turn = 64;
}  // namespace

Sender::Sender(std::unique_ptr<DatagramSender> io) : io_(std::move(io)) {}

Sender::~Sender() { stop(); }

Result<void> Sender::start(const std::string& thread_name) {
  Result<std::thread> started = core::start_thread(thread_name, [this] { run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void Sender::stop() {
  stopped_.store(true, std::memory_order_release);
  io_->wake();
  if (thread_.joinable()) thread_.join();
  const std::scoped_lock lock(mutex_);
  scheduled_.clear();
  scheduled_channels_.clear();
  left_.reset();
}

void Sender::schedule(std::shared_ptr<Channel> channel) {
  {
    const std::scoped_lock lock(mutex_);
    if (stopped()) return;
    scheduled_channels_.push_back(std::move(channel));
  }
  io_->wake();
}

void Sender::schedule(std::shared_ptr<Lane> lane) {
  bool first = false;
  {
    const std::scoped_lock lock(mutex_);
    first = scheduled_.empty();
    scheduled_.push_back(std::move(lane));
  }
  if (first) io_->wake();
}

void Sender::schedule(std::shared_ptr<LeftWork> work) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    if (stopped()) return;  // it shares what owns this sender
    work->next_ = std::exchange(left_, work);
    any_left_.store(true, std::memory_order_release);
  }
  io_->wake();
}

void Sender::run() {
  ::prctl(PR_SET_TIMERSLACK, timer_slack_ns);
  while (!stopped()) {
    wake_at_ = Time::max();
    carry_out_left();
    take_over_scheduled();
    for (Flow& flow : flows_) {
      if (!advance(flow)) flow.lane.reset();
      carry_out_left();
    }
    std::erase_if(flows_, [](const Flow& flow) { return flow.lane == nullptr; });
    for (Attended& attended : attended_) {
      if (!look_after(attended)) attended.channel.reset();
      carry_out_left();
    }
    std::erase_if(attended_, [](const Attended& attended) { return attended.channel == nullptr; });
    io_->await(wake_at_);
  }
  flows_.clear();
  attended_.clear();
}

/// Between flows too: it is small, or will be a flow itself.
void Sender::carry_out_left() {
  if (!any_left_.load(std::memory_order_acquire)) return;
  std::shared_ptr<LeftWork> work;
  {
    const std::scoped_lock lock(mutex_);
    work.swap(left_);
    any_left_.store(false, std::memory_order_relaxed);
  }
  while (work != nullptr) {
    std::shared_ptr<LeftWork> next = std::move(work->next_);  // it may be scheduled again at once
    work->carry_out();
    work = std::move(next);
  }
}

void Sender::take_over_scheduled() {
  {
    const std::scoped_lock lock(mutex_);
    taken_.swap(scheduled_);
    taken_channels_.swap(scheduled_channels_);
  }
  for (std::shared_ptr<Lane>& lane : taken_) flows_.push_back({.lane = std::move(lane)});
  taken_.clear();
  for (std::shared_ptr<Channel>& channel : taken_channels_) {
    Flow small{.lane = {}, .channel = channel, .size = ResendWindow::Size::small};
    Flow large{.lane = {}, .channel = channel, .size = ResendWindow::Size::large};
    attended_.push_back({std::move(channel), std::move(small), std::move(large)});
  }
  taken_channels_.clear();
}

/// Takes the next job of the flow's lane; false if there is none.
bool Sender::begin(Flow& flow) {
  flow.fragments.reset();
  flow.full_since.reset();
  if (flow.lane->channel() != nullptr) return pass_on(*flow.lane);
  const Job* job = flow.lane->next();
  if (job == nullptr) return false;
  flow.fragments.emplace(job->body(), flow.lane->destination().datagram_bytes());
  return true;
}

/// What waited for the history of a late reader, and that itself, goes on reliably. False: nothing is left.
bool Sender::pass_on(Lane& lane) {
  while (lane.next() != nullptr) {
    const JobHandle& job = lane.current();
    const Channel::Posted posted = lane.channel()->post(job, job->first, false);
    if (posted.was_at_rest) schedule(lane.shared_channel());
    wake_at_ = {};
    for (std::size_t i = 0; i < posted.kept.dropped; ++i) lane.losses()->lost(0, 0);
  }
  return false;
}

/// False once it is at rest.
bool Sender::look_after(Attended& attended) {
  advance_channel(attended.small);
  advance_channel(attended.large);
  const Channel::Care care = attended.channel->look_after();
  if (care.heartbeat) send(*care.heartbeat, *attended.channel);
  wake_at_ = std::min(wake_at_, care.next_look);
  return !care.at_rest;
}

/// Small samples go on until there are none, or no room; large ones take turns.
void Sender::advance_channel(Flow& flow) {
  for (std::size_t samples = 0; samples < small_samples_per_turn; ++samples) {
    if (!flow.piece) {
      flow.piece = flow.channel->next(flow.size);
      if (!flow.piece) return;
      flow.full_since.reset();
      flow.fragments.emplace(flow.piece->body(), flow.destination().datagram_bytes(), flow.piece->range);
    }
    if (send_some(flow) == Progress::some) return;
    flow.channel->finished(*flow.piece);  // or it is lost, and will be asked for
    flow.piece.reset();
    flow.fragments.reset();
    if (flow.size == ResendWindow::Size::large) break;
  }
  wake_at_ = {};
}

void Sender::send(const Heartbeat& heartbeat, Channel& channel) {
  std::array<std::byte, heartbeat_bytes> bytes;
  encode(heartbeat, bytes.data());
  const iovec part{bytes.data(), bytes.size()};
  const OutgoingBatch batch{{&part, 1}, 0};
  const SendOutcome outcome = channel.destination().connection().try_send({&batch, 1}).outcome;
  if (outcome == SendOutcome::sent) {
    channel.tally().bytes_sent.fetch_add(bytes.size(), std::memory_order_relaxed);
  } else {
    channel.destination().note(outcome);
  }
}

/// Sends what the flow may send now. False once its lane is empty.
bool Sender::advance(Flow& flow) {
  if (!flow.fragments || flow.lane->closed()) {
    if (!begin(flow)) return false;
  }
  if (must_wait(flow)) return true;
  const Progress progress = send_some(flow);
  if (progress == Progress::some) return true;
  if (progress == Progress::lost) flow.lane->lose_current();
  wake_at_ = {};
  return begin(flow);
}

/// Large samples of one writer go to a destination one after another, under whichever masks: a receiver puts
/// only so many together at a time, and the first is whole sooner. Small ones pass between.
bool Sender::must_wait(const Flow& flow) const {
  if (flow.fragments->begun() || flow.fragments->bytes() <= batch_bytes_max) return false;
  return std::any_of(flows_.begin(), flows_.end(), [&](const Flow& other) {
    return other.fragments && other.fragments->begun() && &other.lane->tally() == &flow.lane->tally() &&
           &other.lane->destination() == &flow.lane->destination();
  });
}

Sender::Progress Sender::send_some(Flow& flow) {
  Destination& to = flow.destination();
  const Time now = Clock::now();
  if (to.connection().full()) return wait_for_room(flow, now);
  const std::size_t cut = cut_batches(*flow.fragments, to, now);
  const Connection::Sent sent = to.connection().try_send({outgoing_.data(), cut});
  std::size_t sent_bytes = 0, kept_bytes = 0;
  for (std::size_t i = 0; i < cut; ++i) (i < sent.batches ? sent_bytes : kept_bytes) += batches_[i].bytes();
  flow.tally().bytes_sent.fetch_add(sent_bytes, std::memory_order_relaxed);
  to.pacer().give_back(kept_bytes);
  if (sent.batches > 0) {
    flow.fragments = rest_[sent.batches - 1];
    flow.full_since.reset();
  }
  if (sent.outcome == SendOutcome::would_wait) return wait_for_room(flow, now);
  if (sent.outcome != SendOutcome::sent) {
    const std::size_t refused = to.datagram_bytes();
    to.note(sent.outcome);
    if (sent.outcome != SendOutcome::too_long || to.datagram_bytes() >= refused) return Progress::lost;
    flow.fragments->set_datagram_bytes(to.datagram_bytes());
    wake_at_ = {};
    return Progress::some;
  }
  if (flow.fragments->done()) return Progress::whole;
  wake_at_ = std::min(wake_at_, to.pacer().next_ready(now));
  return Progress::some;
}

/// As many as may go now.
std::size_t Sender::cut_batches(Fragmenter fragments, Destination& to, Time now) {
  to.pacer().set_burst(to.burst_bytes());
  std::size_t n = 0;
  for (; n < batches_per_call && !fragments.done() && to.pacer().ready(now); ++n) {
    fragments.next(batches_[n], to.burst_bytes(), to.datagrams_per_call());
    to.pacer().spend(batches_[n].bytes());
    outgoing_[n] = {batches_[n].parts(), batches_[n].segment_bytes()};
    rest_[n] = fragments;
  }
  return n;
}

Sender::Progress Sender::wait_for_room(Flow& flow, Time now) {
  if (!flow.full_since) flow.full_since = now;
  const Time at_most = *flow.full_since + patience;
  if (now >= at_most) return Progress::lost;
  flow.destination().connection().wait_for_room();
  wake_at_ = std::min(wake_at_, at_most);
  return Progress::some;
}

}  // namespace sft::udp
