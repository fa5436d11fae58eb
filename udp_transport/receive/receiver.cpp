#include "udp_transport/receive/receiver.h"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

#include "core/platform/doorbell.h"
#include "core/platform/thread.h"
#include "core/sync/spin.h"
#include "udp_transport/send/answers.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
constexpr int trains_per_turn = 64;  // then a thread that waits may have the role
/// To a reader in order, without a look at whether it is still there.
constexpr std::size_t delivered_at_once = 256;

/// Of an eventfd or timerfd.
void read_away(int fd) noexcept {
  eventfd_t ignored = 0;
  ::eventfd_read(fd, &ignored);
}
}  // namespace

Receiver::Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
                   std::size_t receive_buffer_bytes, std::shared_ptr<core::BufferPool> pool, Acks acks,
                   Groups groups)
    : io_(std::move(io)),
      acks_(std::move(acks)),
      groups_(std::move(groups)),
      shares_(receive_buffer_bytes),
      reassembly_(limits, std::move(pool)) {}

Result<void> Receiver::start(const core::ThreadSpec& thread) {
  alarm_ = FileDescriptor(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  waiter_event_ = FileDescriptor(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!alarm_ || !waiter_event_)
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  Result<std::thread> started = core::start_thread(thread, [self = shared_from_this()] { self->run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void Receiver::stop() {
  role_.close();
  io_->wake();
  ::eventfd_write(waiter_event_.get(), 1);
  if (!thread_.joinable()) return;
  if (thread_.get_id() == std::this_thread::get_id()) {
    thread_.detach();  // ends by itself, on what it keeps alive
  } else {
    thread_.join();
  }
}

void Receiver::add(const core::ReaderSpec& reader) {
  if (reader.only_waited_for) return;
  spins_.add(reader.spin);
  if (role_.add_tended()) {
    io_->wake();
    ::eventfd_write(waiter_event_.get(), 1);
  }
  while (role_.waiter_in_turn()) std::this_thread::yield();
}

void Receiver::remove(const core::ReaderSpec& reader) {
  if (reader.only_waited_for) return;
  spins_.remove(reader.spin);
  role_.remove_tended();
}

void Receiver::run() {
  bool stood_by = false;
  for (;;) {
    const ReceivingRole::Task task = role_.next(Clock::now(), stood_by && readable());
    if (task.evicts) ::eventfd_write(waiter_event_.get(), 1);
    stood_by = task.duty == ReceivingRole::Duty::stand_by;
    if (task.duty == ReceivingRole::Duty::stop) break;
    if (task.duty == ReceivingRole::Duty::receive) receive_alone();
    if (task.duty == ReceivingRole::Duty::poll) poll(task.until);
    if (stood_by) stand_by(task.until);
  }
  while (role_.waiter_in_turn()) std::this_thread::yield();
  io_->finish();
}

void Receiver::receive_alone() {
  const Time begun = Clock::now();
  now_.steady = {};
  const bool works = io_->receive(*this, next_deadline(), spin_choice_.choose(spins_.largest()));
  spin_choice_.waited(now_.steady == Time{} ? Clock::duration::max() : now_.steady - begun);
  look_after_time();
  if (role_.end_turn(next_deadline())) ::eventfd_write(waiter_event_.get(), 1);
  if (works) return;
  broken_.store(true, std::memory_order_relaxed);
  role_.close();
}

/// As long as threads that wait come and go: they take the role without having to wake this one.
void Receiver::poll(Time until) {
  const auto [datagrams, wake] = io_->descriptors();
  std::array<pollfd, 3> ready{{{.fd = datagrams, .events = POLLIN, .revents = 0},
                               {.fd = wake, .events = POLLIN, .revents = 0},
                               {.fd = alarm_.get(), .events = POLLIN, .revents = 0}}};
  poll_until(ready, until);
  if (ready[1].revents != 0) read_away(wake);
  if (ready[2].revents != 0) note_alarm();
  if (!role_.take_turn()) return;
  for (int i = 0; i < trains_per_turn && io_->receive_now(*this); ++i) {
  }
  look_after_time();
  if (role_.end_turn(next_deadline())) ::eventfd_write(waiter_event_.get(), 1);
}

void Receiver::stand_by(Time until) {
  const int wake = io_->descriptors().wake;
  std::array<pollfd, 2> ready{
      {{.fd = wake, .events = POLLIN, .revents = 0}, {.fd = alarm_.get(), .events = POLLIN, .revents = 0}}};
  if (!poll_until(ready, until)) return;
  if (ready[0].revents != 0) read_away(wake);
  if (ready[1].revents != 0) note_alarm();
}

void Receiver::note_alarm() {
  read_away(alarm_.get());
  role_.alarm_rang();
}

bool Receiver::readable() const noexcept {
  std::array<pollfd, 1> socket{{{.fd = io_->descriptors().datagrams, .events = POLLIN, .revents = 0}}};
  return poll_until(socket, {});
}

bool Receiver::receive(const void* who, const core::Waiting& waiting) noexcept {
  switch (role_.enter(Clock::now())) {
    case ReceivingRole::Entry::refused:
      return false;
    case ReceivingRole::Entry::occupied:
      wait_behind(waiting);
      return true;
    case ReceivingRole::Entry::promised:
      io_->wake();
      break;
    case ReceivingRole::Entry::taken:
      break;
  }
  waiter_.store(who, std::memory_order_seq_cst);
  wait_in_role(waiting);
  waiter_.store(nullptr, std::memory_order_relaxed);
  leave_role();
  return true;
}

void Receiver::interrupt(const void* who) noexcept {
  if (waiter_.load(std::memory_order_seq_cst) == who) ::eventfd_write(waiter_event_.get(), 1);
}

/// Another one delivers to it.
void Receiver::wait_behind(const core::Waiting& waiting) noexcept {
  if (role_.wait_behind()) io_->wake();
  if (!waiting.bell.spin(waiting.seen, waiting.spin_until))
    waiting.bell.wait(waiting.deadline, [&] { return waiting.bell.rung(waiting.seen); });
  role_.unwait_behind();
}

void Receiver::wait_in_role(const core::Waiting& waiting) noexcept {
  if (readers_lag_.load(std::memory_order_relaxed)) deliver_to_laggards();
  while (!waiting.bell.rung(waiting.seen) && !role_.lost()) {
    const Time now = Clock::now();
    if (now >= waiting.deadline) return;
    if (now >= waiting.spin_until) {
      sleep_in_role(waiting.deadline);
    } else if (!receive_turn()) {
      core::pause_core(), ::sched_yield();
    }
  }
}

/// Whoever waits has taken what it had, and may have room.
void Receiver::deliver_to_laggards() noexcept {
  if (!role_.begin()) return;
  const Time now = Clock::now();
  look_after_readers(now);
  answer(now);
  role_.end(next_deadline());
}

/// One train, so that whoever waits for a sample that it brings need not wait for others. True if there was
/// one.
bool Receiver::receive_turn() noexcept {
  if (!role_.begin()) return false;
  const bool came = io_->receive_now(*this);
  look_after_time();
  role_.end(next_deadline());
  return came;
}

void Receiver::sleep_in_role(Time until) noexcept {
  const bool mine = role_.begin();
  if (mine) {
    until = std::min(until, next_deadline());
    role_.end(next_deadline());
  }
  std::array<pollfd, 2> ready{{{.fd = waiter_event_.get(), .events = POLLIN, .revents = 0},
                               {.fd = io_->descriptors().datagrams, .events = POLLIN, .revents = 0}}};
  poll_until(std::span(ready).first(mine ? 2 : 1), until);
  if (ready[0].revents != 0) read_away(waiter_event_.get());
  receive_turn();
}

void Receiver::leave_role() noexcept {
  const ReceivingRole::Leaving leaving = role_.leave(Clock::now());
  if (leaving.wake) io_->wake();
  if (!leaving.set_alarm) return;
  itimerspec when{};
  when.it_value.tv_nsec = std::chrono::nanoseconds(ReceivingRole::vacancy).count();
  ::timerfd_settime(alarm_.get(), 0, &when, nullptr);
}

void Receiver::look_after_time() noexcept {
  if (next_deadline() == Time::max()) return;
  const Time now = Clock::now();
  if (now >= lag_watch_.next_look()) look_after_readers(now);
  answer(now);
  reassembly_.expire(now);
  publish_counters();
}

Receiver::Time Receiver::next_deadline() const {
  return std::min({reassembly_.next_answer(), reassembly_.next_expiry().value_or(Clock::time_point::max()),
                   lag_watch_.next_look()});
}

void Receiver::answer(Time now) noexcept try {
  reassembly_.answer(now, acks_.send);
  reassembly_.report(groups_.send);
} catch (const std::bad_alloc&) {  // it is asked for later
}

void Receiver::begin(ArrivalTime now) noexcept {
  now_ = now;
  enter();
}

void Receiver::datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept {
  const std::optional<DatagramKind> kind = kind_of(bytes);
  if (is_answer(kind)) return acks_.hear(bytes, from, now_.steady);
  if (kind == DatagramKind::mark) return report(bytes, from);
  if (kind == DatagramKind::group_offer) return hear_offer(bytes, from);
  shares_.count(from);
  Reassembly::Arrival arrival =
      kind == DatagramKind::heartbeat ? accept_heartbeat(bytes, from) : accept(bytes, from);
  const bool in_channel = arrival.in_channel;
  const bool any = arrival.sample || !arrival.packed.empty();
  if (!any && !in_channel) return;
  if (from.ip != last_from_) reassembly_.came_from(arrival.stream, last_from_ = from.ip);
  const core::EndpointId writer = wanted_->streams[arrival.stream].writer;
  if (any) deliver(arrival);
  if (in_channel) deliver_in_order(writer);
}

/// At once: all that was sent before it has left the socket.
void Receiver::report(std::span<const std::byte> bytes, SocketAddress from) noexcept try {
  const std::optional<FlowMark> mark = parse_mark(bytes);
  if (!mark) {
    ++malformed_marks_;
  } else {
    const std::optional<SocketAddress> to = reassembly_.report_address(from.ip, mark->port);
    unknown_marks_ += to ? 0 : 1;
    if (to) acks_.report(*to, shares_.answer(*mark, from, now_.steady));
  }
} catch (const std::bad_alloc&) {  // it will be marked again
}

void Receiver::hear_offer(std::span<const std::byte> bytes, SocketAddress from) noexcept try {
  const std::optional<Reassembly::Joining> joining = reassembly_.accept_offer(bytes, from, now_);
  if (!joining) return;
  groups_.joins->keep_to(reassembly_.groups());
  if (joining->group != 0) groups_.joins->join(joining->group, from, joining->anew);
} catch (const std::bad_alloc&) {  // another one will come
}

Reassembly::Arrival Receiver::accept_heartbeat(std::span<const std::byte> bytes, SocketAddress from) noexcept
    try {
  return reassembly_.accept_heartbeat(bytes, from, now_);
} catch (const std::bad_alloc&) {
  return {};
}

Reassembly::Arrival Receiver::accept(std::span<const std::byte> bytes, const SocketAddress& from) noexcept
    try {
  return reassembly_.accept(bytes, now_, from.ip);
} catch (const std::bad_alloc&) {  // as if the datagram had not come
  return {};
}

void Receiver::end() noexcept {
  publish_counters();
  subscriptions_.leave();
  answer(now_.steady);
}

void Receiver::enter() {
  std::shared_ptr<const Subscriptions> latest = subscriptions_.enter();
  if (latest == wanted_) return;
  wanted_ = std::move(latest);
  reassembly_.set_streams(wanted_->streams);
  groups_.joins->keep_to(reassembly_.groups());
  for (std::size_t i = 0; i < wanted_->streams.size(); ++i) {
    ArrivalWindow* window = reassembly_.window(i);
    if (window == nullptr) continue;
    std::vector<core::EndpointId> readers;
    for (const Subscriber& subscriber : wanted_->subscribers[i]) {
      if (subscriber.reliable) readers.push_back(subscriber.reader);
    }
    window->set_readers(readers);
    for (const Subscriber& subscriber : wanted_->subscribers[i])
      window->heard(subscriber.reader, subscriber.heard_request());
  }
}

/// To those who take it as it comes. Listeners run outside the snapshot: they may take long, and may connect
/// and destroy readers.
void Receiver::deliver(Reassembly::Arrival& arrival) {
  publish_counters();
  const auto in_turn = [&](const Subscriber& s) { return arrival.in_channel && s.reliable; };
  if (std::ranges::all_of(wanted_->subscribers[arrival.stream], in_turn)) return;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  subscriptions_.leave();
  const std::span samples = arrival.sample ? std::span(&arrival.sample, 1) : arrival.packed;
  for (const Subscriber& subscriber : subscriptions->subscribers[arrival.stream]) {
    if (in_turn(subscriber)) continue;
    batch_.clear();
    std::ranges::copy_if(samples, std::back_inserter(batch_),
                         [&](const core::SampleHandle& sample) { return subscriber.accepts(*sample); });
    subscriber.inbox->deliver(batch_);
  }
  batch_.clear();
  for (core::SampleHandle& sample : samples) sample.reset();
  enter();
}

/// Whether there was something that somebody had room for.
bool Receiver::deliver_in_order(core::EndpointId writer) {
  bool any = false;
  while (deliver_next(writer)) any = true;
  return any;
}

/// To one reader what it can get now, up to a limit. False if nobody has anything to get. What a publisher
/// that waits for its readers has sent is not pushed out by what comes next, as long as it does wait.
bool Receiver::deliver_next(core::EndpointId writer) {
  const std::vector<Stream>& streams = wanted_->streams;
  const auto stream =
      std::ranges::find_if(streams, [&](const Stream& candidate) { return candidate.writer == writer; });
  if (stream == streams.end()) return false;
  const auto place = static_cast<std::size_t>(stream - streams.begin());
  ArrivalWindow* window = reassembly_.window(place);
  if (window == nullptr) return false;
  for (const Subscriber& subscriber : wanted_->subscribers[place]) {
    if (!subscriber.reliable) continue;
    const auto accepts = [&](const core::SampleBuffer& s, std::uint64_t request) {
      return subscriber.accepts(s, request);
    };
    const bool room_counts = streams[place].waits && !window->overtakes();
    const std::size_t room = room_counts ? subscriber.inbox->room(writer) : delivered_at_once;
    batch_.clear();
    while (batch_.size() < std::min(room, delivered_at_once)) {
      batch_.push_back(window->next(subscriber.reader, accepts));
      if (batch_.back()) continue;
      batch_.pop_back();
      break;
    }
    if (batch_.empty()) continue;
    window->release();
    const std::shared_ptr<Inbox> inbox = subscriber.inbox;
    const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
    subscriptions_.leave();
    inbox->deliver(batch_);
    batch_.clear();
    enter();
    return true;
  }
  window->release();
  if (window->holds_back()) {
    lag_watch_.begin(now_.steady);
    readers_lag_.store(true, std::memory_order_relaxed);
  }
  return false;
}

void Receiver::look_after_readers(Time now) {
  enter();
  bool some_was_taken = false;
  bool some_is_left = false;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  for (const Stream& stream : subscriptions->streams) {
    if (stream.waits) some_was_taken = deliver_in_order(stream.writer) || some_was_taken;
  }
  for (std::size_t i = 0; i < wanted_->streams.size(); ++i) {
    const ArrivalWindow* window = reassembly_.window(i);
    some_is_left = some_is_left || (window != nullptr && window->holds_back());
  }
  subscriptions_.leave();
  lag_watch_.looked(now, some_was_taken, some_is_left);
  readers_lag_.store(some_is_left, std::memory_order_relaxed);
}

void Receiver::publish_counters() noexcept {
  const Reassembly::Counters& counters = reassembly_.counters();
  malformed_.store(counters.malformed + malformed_marks_, std::memory_order_relaxed);
  unknown_.store(counters.unknown, std::memory_order_relaxed);
  incomplete_.store(counters.incomplete, std::memory_order_relaxed);
  disbelieved_.store(unknown_marks_, std::memory_order_relaxed);
  over_limit_.store(counters.over_limit, std::memory_order_relaxed);
}

core::Transport::Counters Receiver::counters() const noexcept {
  return {.malformed = malformed_.load(std::memory_order_relaxed),
          .unknown = unknown_.load(std::memory_order_relaxed),
          .incomplete = incomplete_.load(std::memory_order_relaxed),
          .over_limit = over_limit_.load(std::memory_order_relaxed),
          .disbelieved = disbelieved_.load(std::memory_order_relaxed)};
}

}  // namespace sft::udp
