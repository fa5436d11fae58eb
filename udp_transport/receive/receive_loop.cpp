#include "udp_transport/receive/receive_loop.h"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <new>
#include <utility>

#include "core/platform/doorbell.h"
#include "core/platform/thread.h"
#include "core/sync/spin.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
// Number of trains after which a waiting thread may get the receiving role.
constexpr int trains_per_turn = 64;
constexpr int trains_per_hand_over = 1024;

/// Reads an eventfd or timerfd, so that it is not readable any more.
void read_away(int fd) noexcept {
  eventfd_t ignored = 0;
  ::eventfd_read(fd, &ignored);
}

bool is_readable(int socket) noexcept {
  std::array<pollfd, 1> ready{{{.fd = socket, .events = POLLIN, .revents = 0}}};
  return poll_until(ready, {});
}
}  // namespace

ReceiveLoop::ReceiveLoop(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
                         std::size_t receive_buffer_bytes, std::shared_ptr<core::BufferPool> pool,
                         SendingHalf sending_half, const std::shared_ptr<GroupJoins>& joins)
    : io_(std::move(io)),
      send_ack_(std::move(sending_half.send_ack)),
      send_group_report_(std::move(sending_half.send_group_report)),
      reassembly_(limits, std::move(pool)),
      demultiplexer_(
          {.hear_answer = std::move(sending_half.hear_answer),
           .send_report = std::move(sending_half.send_report),
           .keep_groups = [joins](std::span<const std::uint32_t> groups) { joins->keep_to(groups); },
           .join_group = [joins](std::uint32_t group, const SocketAddress& towards,
                                 bool anew) { joins->join(group, towards, anew); }},
          reassembly_, receive_buffer_bytes),
      delivery_(reassembly_, [joins](std::span<const std::uint32_t> groups) { joins->keep_to(groups); }) {}

Result<void> ReceiveLoop::start(const core::ThreadSpec& thread) {
  alarm_ = FileDescriptor(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  if (!alarm_)
    return fail(Errc::system, "cannot create a timerfd; raise the limit on open files (ulimit -n)");
  Result<FileDescriptor> waiter_event = open_wake_event();
  if (!waiter_event) return tl::unexpected<Error>(std::move(waiter_event.error()));
  waiter_event_ = std::move(*waiter_event);
  Result<std::thread> started = core::start_thread(thread, [self = shared_from_this()] { self->run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void ReceiveLoop::stop() {
  role_.close();
  io_->wake();
  ::eventfd_write(waiter_event_.get(), 1);
  if (!thread_.joinable()) return;
  if (thread_.get_id() == std::this_thread::get_id()) {
    thread_.detach();  // the thread ends by itself, and keeps this loop alive until then
  } else {
    thread_.join();
  }
}

void ReceiveLoop::add(const core::ReaderSpec& reader) {
  if (reader.only_waited_for) return;
  spins_.add(reader.spin);
  if (role_.add_attended()) {
    io_->wake();
    ::eventfd_write(waiter_event_.get(), 1);
  }
  while (role_.waiter_in_turn()) std::this_thread::yield();
}

void ReceiveLoop::remove(const core::ReaderSpec& reader) {
  if (reader.only_waited_for) return;
  spins_.remove(reader.spin);
  role_.remove_attended();
}

void ReceiveLoop::run() {
  bool stood_by = false;
  for (;;) {
    const ReceivingRole::Task task =
        role_.next(Clock::now(), stood_by && is_readable(io_->descriptors().datagrams));
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

void ReceiveLoop::receive_alone() {
  const Time begun = Clock::now();
  now_.steady = {};
  const auto limit = spins_.largest();
  const bool works = io_->receive(*this, next_deadline(), spinning_.spin(limit));
  const bool found = now_.steady != Time{};
  spinning_.waited(found ? now_.steady - begun : Clock::duration::max(), found, limit);
  end_hand_over();
  look_after_time();
  if (role_.end_turn(next_deadline())) ::eventfd_write(waiter_event_.get(), 1);
  if (!works) give_up();
}

/// Stops receiving. Called if the program has closed the descriptors of this loop (closefrom(3)), without
/// which the loop cannot wait.
void ReceiveLoop::give_up() {
  broken_.store(true, std::memory_order_relaxed);
  role_.close();
}

/// Waits for datagrams in the transport's own thread, without the receiving role. Meanwhile threads that
/// wait for samples can take the role without waking this thread.
void ReceiveLoop::poll(Time until) {
  const auto [datagrams, wake] = io_->descriptors();
  std::array<pollfd, 3> ready{{{.fd = datagrams, .events = POLLIN, .revents = 0},
                               {.fd = wake, .events = POLLIN, .revents = 0},
                               {.fd = alarm_.get(), .events = POLLIN, .revents = 0}}};
  poll_until(ready, until);
  if (((ready[0].revents | ready[1].revents) & POLLNVAL) != 0) return give_up();
  if (ready[1].revents != 0) read_away(wake);
  if (ready[2].revents != 0) note_alarm();
  if (!role_.take_turn()) return;
  for (int i = 0; i < trains_per_turn && io_->receive_now(*this); ++i) {
  }
  end_hand_over();
  look_after_time();
  if (role_.end_turn(next_deadline())) ::eventfd_write(waiter_event_.get(), 1);
}

void ReceiveLoop::stand_by(Time until) {
  const int wake = io_->descriptors().wake;
  std::array<pollfd, 2> ready{
      {{.fd = wake, .events = POLLIN, .revents = 0}, {.fd = alarm_.get(), .events = POLLIN, .revents = 0}}};
  if (!poll_until(ready, until)) return;
  if ((ready[0].revents & POLLNVAL) != 0) return give_up();
  if (ready[0].revents != 0) read_away(wake);
  if (ready[1].revents != 0) note_alarm();
}

void ReceiveLoop::note_alarm() {
  read_away(alarm_.get());
  role_.alarm_rang();
}

bool ReceiveLoop::receive(const core::Waiting& waiting) noexcept {
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
  wait_in_role(waiting);
  leave_role();
  return true;
}

void ReceiveLoop::wake_receiver() noexcept { ::eventfd_write(waiter_event_.get(), 1); }

/// Waits for a sample while another thread receives, and delivers to the reader of this thread.
void ReceiveLoop::wait_behind(const core::Waiting& waiting) noexcept {
  if (role_.wait_behind()) io_->wake();
  if (!waiting.bell.spin(waiting.seen, waiting.spin_until))
    waiting.bell.wait(waiting.deadline, [&] { return waiting.bell.rung(waiting.seen); });
  role_.unwait_behind();
}

void ReceiveLoop::wait_in_role(const core::Waiting& waiting) noexcept {
  if (delivery_.readers_lag()) deliver_to_laggards();
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

/// Delivers to readers whose inboxes were full. Called when a waiting thread has taken samples of its
/// reader, so that the inbox may have room.
void ReceiveLoop::deliver_to_laggards() noexcept {
  if (!role_.begin()) return;
  const Time now = Clock::now();
  delivery_.look_after_readers(now);
  answer(now);
  role_.end(next_deadline());
}

/// Receives only one train of datagrams, so that a thread that waits for a sample in this train need not
/// wait for further trains. Returns true if there was a train.
bool ReceiveLoop::receive_turn() noexcept {
  if (!role_.begin()) return false;
  const bool came = io_->receive_now(*this);
  end_hand_over();
  look_after_time();
  role_.end(next_deadline());
  return came;
}

/// Delivers the samples that wait for earlier ones (HandOver). The waiting samples came by unicast. So the
/// samples that were sent before are in the socket for groups by now, or were lost. That socket is read
/// first.
void ReceiveLoop::end_hand_over() noexcept {
  if (!delivery_.hands_over()) [[likely]]
    return;
  for (int i = 0; i < trains_per_hand_over && delivery_.hands_over() && io_->receive_from_groups(*this);
       ++i) {
  }
  delivery_.end_hand_over();
}

void ReceiveLoop::sleep_in_role(Time until) noexcept {
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

void ReceiveLoop::leave_role() noexcept {
  const ReceivingRole::Leaving leaving = role_.leave(Clock::now());
  if (leaving.wake) io_->wake();
  if (!leaving.set_alarm) return;
  itimerspec when{};
  when.it_value.tv_nsec = std::chrono::nanoseconds(ReceivingRole::vacancy).count();
  ::timerfd_settime(alarm_.get(), 0, &when, nullptr);
}

void ReceiveLoop::look_after_time() noexcept {
  if (next_deadline() == Time::max()) return;
  const Time now = Clock::now();
  if (now >= delivery_.next_look()) delivery_.look_after_readers(now);
  answer(now);
  reassembly_.expire(now);
  publish_counters();
}

ReceiveLoop::Time ReceiveLoop::next_deadline() const {
  return std::min({reassembly_.next_answer(), reassembly_.next_expiry().value_or(Clock::time_point::max()),
                   delivery_.next_look()});
}

void ReceiveLoop::answer(Time now) noexcept try {
  reassembly_.answer(now, send_ack_);
  reassembly_.report_groups(send_group_report_);
} catch (const std::bad_alloc&) {  // missing parts are requested later
}

void ReceiveLoop::begin(ArrivalTime now) noexcept {
  now_ = now;
  delivery_.enter();
}

void ReceiveLoop::datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept {
  Arrival arrival = demultiplexer_.accept(bytes, from, now_);
  if (arrival.is_empty()) return;
  if (arrival.has_samples()) publish_counters();  // before listeners are called, which may read the counters
  delivery_.deliver(arrival, now_.steady);
}

void ReceiveLoop::end() noexcept {
  publish_counters();
  delivery_.leave();
  answer(now_.steady);
}

void ReceiveLoop::publish_counters() noexcept {
  core::Transport::Counters counters = reassembly_.counters();
  counters.rejected = demultiplexer_.unknown_marks();
  published_.store(counters);
}

void ReceiveLoop::PublishedCounters::store(const core::Transport::Counters& counters) noexcept {
  malformed_.store(counters.malformed, std::memory_order_relaxed);
  unknown_.store(counters.unknown, std::memory_order_relaxed);
  incomplete_.store(counters.incomplete, std::memory_order_relaxed);
  over_limit_.store(counters.over_limit, std::memory_order_relaxed);
  rejected_.store(counters.rejected, std::memory_order_relaxed);
}

core::Transport::Counters ReceiveLoop::PublishedCounters::load() const noexcept {
  return {.malformed = malformed_.load(std::memory_order_relaxed),
          .unknown = unknown_.load(std::memory_order_relaxed),
          .incomplete = incomplete_.load(std::memory_order_relaxed),
          .over_limit = over_limit_.load(std::memory_order_relaxed),
          .rejected = rejected_.load(std::memory_order_relaxed)};
}

}  // namespace sft::udp
