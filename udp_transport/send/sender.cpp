#include "udp_transport/send/sender.h"

#include <sys/prctl.h>

#include <algorithm>
#include <utility>

#include "core/platform/thread.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
constexpr unsigned long timer_slack_ns = 1000;  // the default would add 50 us to pauses that may be as short
/// A sample that waits longer for its connection is dropped: its memory is worth more elsewhere, and a
/// receiver that had a part of it has given up.
constexpr std::chrono::seconds patience{2};
constexpr std::size_t small_samples_per_turn = 64;
constexpr std::size_t answers_at_once = 64;  // strangers may send more than can be heard
}  // namespace

/// A small sample overtakes large ones, unless it has to arrive behind one of them.
Connection& Sender::Flow::connection() const {
  if (size == Size::large) return destination().bulk();
  return lane ? destination().connection_after(lane->behind()) : destination().connection();
}

Sender::Sender(std::unique_ptr<DatagramSender> io, std::uint64_t max_bytes_per_s)
    : io_(std::move(io)), limit_(max_bytes_per_s) {}

Sender::~Sender() { stop(); }

Result<void> Sender::start(const core::ThreadSpec& thread, Hear hear) {
  hear_ = std::move(hear);
  Result<std::thread> started = core::start_thread(thread, [this] { run(); });
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
  deferred_.reset();
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

void Sender::schedule(std::shared_ptr<DeferredWork> work) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    if (stopped()) return;  // it shares what owns this sender
    work->next_ = std::exchange(deferred_, work);
    any_deferred_.store(true, std::memory_order_release);
  }
  io_->wake();
}

void Sender::run() {
  ::prctl(PR_SET_TIMERSLACK, timer_slack_ns);
  while (!stopped()) {
    wake_at_ = Time::max();
    hear_answers();
    carry_out_deferred();
    take_over_scheduled();
    send_small();
    send_large();
    io_->await(wake_at_);
    forget_finished();  // not before: a connection of theirs may have been waited for
  }
  flows_.clear();
  attended_.clear();
}

/// Called between the calls for a large sample, too: the sample goes on without waiting as long as answers
/// come in time.
void Sender::hear_answers() {
  std::array<std::byte, datagram_bytes_min> answer;
  for (std::size_t i = 0; i < answers_at_once; ++i) {
    const DatagramSender::Answer came = io_->take_answer(answer);
    if (came.bytes == 0) return;
    if (hear_ && hear_(std::span(answer).first(came.bytes), came.from, Clock::now()) != Wake::none)
      wake_at_ = {};
  }
}

void Sender::send_small() {
  for (Flow& flow : flows_) {
    if (flow.lane->closed()) flow.fragments.reset();
    if (!flow.fragments && !begin(flow)) flow.lane.reset();
    if (flow.lane && flow.fragments && flow.size == Size::small) advance(flow);
  }
  for (Attended& attended : attended_) {
    advance_channel(attended.small);
    look_after(attended);
  }
}

/// Large samples go one after another, beginning with another one each time: where there is room for a few
/// only, each has its turn.
void Sender::send_large() {
  const std::size_t count = flows_.size() + attended_.size();
  if (count == 0) return;
  ++turn_;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t which = (turn_ + i) % count;
    if (which >= flows_.size()) {
      Attended& attended = attended_[which - flows_.size()];
      if (attended.channel) advance_channel(attended.large);
    } else if (Flow& flow = flows_[which]; flow.lane && flow.fragments && flow.size == Size::large) {
      advance(flow);
    }
    carry_out_deferred();
  }
}

void Sender::forget_finished() {
  std::erase_if(flows_, [](const Flow& flow) { return flow.lane == nullptr; });
  std::erase_if(attended_, [](const Attended& attended) { return attended.channel == nullptr; });
}

/// Called between flows, too: a deferred sample is small, or becomes a flow itself.
void Sender::carry_out_deferred() {
  if (!any_deferred_.load(std::memory_order_acquire)) return;
  std::shared_ptr<DeferredWork> work;
  {
    const std::scoped_lock lock(mutex_);
    work.swap(deferred_);
    any_deferred_.store(false, std::memory_order_relaxed);
  }
  while (work != nullptr) {
    std::shared_ptr<DeferredWork> next = std::move(work->next_);  // it may be scheduled again at once
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
    Flow small{.lane = {}, .channel = channel, .size = Size::small};
    Flow large{.lane = {}, .channel = channel, .size = Size::large};
    attended_.push_back({std::move(channel), std::move(small), std::move(large)});
  }
  taken_channels_.clear();
}

/// Takes the next job of the flow's lane; false if there is none.
bool Sender::begin(Flow& flow) {
  flow.fragments.reset();
  flow.full_since.reset();
  if (flow.lane->channel() != nullptr) return pass_on(flow);
  const Job* job = flow.lane->next();
  if (job == nullptr) return false;
  flow.size = KeptSamples::size_of(job->first.total);
  flow.fragments.emplace(job->body(), flow.lane->destination().datagram_bytes(), BodyRange{job->sent_bytes});
  return true;
}

/// Hands the history of a late reader, and what waited for it, to the channel as far as there is room:
/// nothing has to go there for samples that can wait here. False if nothing remains.
bool Sender::pass_on(Flow& flow) {
  Lane& lane = *flow.lane;
  if (lane.closed()) flow.waits_for_room = false;
  while (flow.waits_for_room || lane.next() != nullptr) {
    const JobHandle& job = lane.current();
    flow.waits_for_room = !lane.channel()->has_room_or_tells(*job);
    if (flow.waits_for_room) return true;
    const Channel::Posted posted = lane.channel()->post(job, job->first, false);
    lane.passed_on(posted.kept.ordinal);
    if (posted.wake == Wake::schedule) schedule(lane.shared_channel());
    wake_at_ = {};
    for (std::size_t i = 0; i < posted.kept.dropped; ++i) lane.losses()->lost(0, 0);
  }
  return false;
}

void Sender::look_after(Attended& attended) {
  const Channel::Care care = attended.channel->look_after();
  if (care.heartbeat) send(*care.heartbeat, attended);
  wake_at_ = std::min(wake_at_, care.next_look);
  if (!care.at_rest) return;
  attended.channel.reset();
  wake_at_ = {};  // what it keeps is let go of
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
    if (is_under_way(send_some(flow))) return;
    static_cast<void>(flow.channel->finished(*flow.piece, Clock::now()));  // or lost, and will be asked for
    flow.piece.reset();
    flow.fragments.reset();
    if (flow.size == Size::large) break;
  }
  wake_at_ = {};
}

/// Uses a connection that cannot overtake the samples that the heartbeat reports.
void Sender::send(const Heartbeat& heartbeat, const Attended& attended) {
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

/// Sends what the flow may send now, and takes its next job when there is nothing left.
void Sender::advance(Flow& flow) {
  if (must_wait(flow)) return;
  const Progress progress = send_some(flow);
  if (is_under_way(progress)) return;
  if (progress == Progress::lost) flow.lane->lose_current();
  if (flow.size == Size::large) flow.lane->stay_behind(flow.behind);
  wake_at_ = {};
  if (!begin(flow)) flow.lane.reset();
}

/// Large samples of one writer go to a destination one after another, under whichever masks: a receiver puts
/// only so many together at a time, and the first is whole sooner. Small ones pass between.
bool Sender::must_wait(const Flow& flow) const {
  if (flow.fragments->begun() || flow.size == Size::small) return false;
  return std::any_of(flows_.begin(), flows_.end(), [&](const Flow& other) {
    return other.fragments && other.fragments->begun() && &other.lane->tally() == &flow.lane->tally() &&
           &other.lane->destination() == &flow.lane->destination();
  });
}

/// Sends what may go in one turn.
Sender::Progress Sender::send_some(Flow& flow) {
  Progress progress = Progress::some;
  for (int calls = 0; progress == Progress::some && calls < calls_per_turn; ++calls) {
    if (calls > 0) hear_answers();
    progress = send_a_few(flow);
  }
  if (progress == Progress::some) wake_at_ = {};
  return progress;
}

Sender::Progress Sender::send_a_few(Flow& flow) {
  Destination& to = flow.destination();
  Connection& by = flow.connection();
  const Time now = Clock::now();
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
    const std::size_t refused = to.datagram_bytes();
    to.note(sent.outcome);
    if (sent.outcome != SendOutcome::too_long || to.datagram_bytes() >= refused) return Progress::lost;
    flow.fragments->set_datagram_bytes(to.datagram_bytes());
    return Progress::some;
  }
  return flow.fragments->done() ? Progress::whole : Progress::some;
}

void Sender::account_for(Flow& flow, Connection& by, std::size_t batches, Time now) {
  std::size_t bytes = 0, datagrams = 0;
  for (const Batch& batch : std::span(batches_).first(batches)) {
    bytes += batch.bytes();
    datagrams += batch.datagrams();
  }
  flow.tally().bytes_sent.fetch_add(bytes, std::memory_order_relaxed);
  flow.tally().limit.spend(bytes);
  limit_.spend(bytes);
  flow.destination().sent(by, bytes, datagrams, now);
  if (flow.size == Size::large) flow.behind = flow.destination().position();
}

std::size_t Sender::allowance(Destination& to, RateLimit& of_writer, Size size, Time now) {
  const bool small = size == Size::small;
  if (!of_writer.ready(small, now) || !limit_.ready(small, now)) return 0;
  const std::size_t room = to.room(small ? Destination::Size::small : Destination::Size::large, now);
  return std::min({room, of_writer.batch_bytes(), limit_.batch_bytes()});
}

/// The flow has no allowance: it is looked at again once it has some.
void Sender::wait_for_allowance(Flow& flow, Time now) {
  const bool small = flow.size == Size::small;
  for (RateLimit* limit : {&flow.tally().limit, &limit_}) {
    if (limit->ready(small, now)) continue;
    wake_at_ = std::min(wake_at_, limit->next_ready(small, now));
    return;
  }
  flow.destination().mark(now);
  wake_at_ = std::min(wake_at_, flow.destination().next_ready(now));
}

/// Cuts as many batches as may go now.
std::size_t Sender::cut_batches(Flow& flow, Time now) {
  Destination& to = flow.destination();
  Fragmenter fragments = *flow.fragments;
  const std::size_t allowed = allowance(to, flow.tally().limit, flow.size, now);
  if (allowed == 0) wait_for_allowance(flow, now);
  const std::size_t bytes_max = std::min(allowed, to.batch_bytes());
  const std::size_t call_bytes = std::min(allowed, bytes_per_call);
  std::size_t n = 0;
  for (std::size_t cut = 0; n < batches_per_call && !fragments.done() && cut < call_bytes; ++n) {
    fragments.next(batches_[n], bytes_max, to.datagrams_per_call());
    if (batches_[n].bytes() > allowed && !to.answers()) {  // not even one datagram of it
      wait_for_allowance(flow, now);
      break;
    }
    cut += socket_bytes(batches_[n].bytes(), batches_[n].datagrams());
    outgoing_[n] = {batches_[n].parts(), batches_[n].segment_bytes()};
    rest_[n] = fragments;
  }
  return n;
}

Sender::Progress Sender::wait_for_room(Flow& flow, Connection& by, Time now) {
  if (!flow.full_since) flow.full_since = now;
  const Time at_most = *flow.full_since + patience;
  if (now >= at_most) return Progress::lost;
  by.wait_for_room();
  wake_at_ = std::min(wake_at_, at_most);
  return Progress::none;
}

}  // namespace sft::udp
