#include "core/subscribe/subscriber_core.h"

#include <algorithm>
#include <utility>

#include "core/platform/clock.h"
#include "core/subscribe/requirements.h"

namespace sft::core {

namespace {

using namespace std::chrono_literals;

thread_local int callback_depth = 0;
constexpr std::size_t gone_writers_kept = 64;            // their last samples may still be taken
constexpr std::chrono::microseconds slow_callback{200};  // far more than handing over to another thread costs
constexpr int quick_again_after = 100;                   // callbacks in a row

/// Of one writer the next is always newer, whatever was done to its clock.
bool is_newer(const SampleInfo& next, const SampleInfo& latest) {
  return next.writer == latest.writer || next.source_stamp > latest.source_stamp;
}
}  // namespace

bool SubscriberCore::in_callback() noexcept { return callback_depth != 0; }

SubscriberCore::SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder)
    : spec_(std::move(spec)),
      bell_(bell),
      recorder_(std::move(recorder)),
      events_(spec_.options.on_event),
      requested_(spec_.requirement.mask),
      min_period_us_(spec_.min_period_us) {
  if (spec_.as_remote == nullptr) return;
  remote_.emplace(type(), spec_.as_remote);
  requests(requested_, requests_);
}

void SubscriberCore::set_port(TransportKind kind, std::shared_ptr<ReaderPort> port) {
  const std::shared_ptr<ReaderPort> udp = udp_port();
  if (kind == TransportKind::shm && port != nullptr && udp != nullptr) udp->share_reader();
  const std::scoped_lock lock(mutex_);
  inlets_[static_cast<std::size_t>(kind)].port.swap(
      port);  // the old one dies with the argument, behind the lock
  if (port == nullptr) return;
  gone_.lost += port->lost_unnoticed();
  discarded_before_ += port->discarded();
  held_too_many_before_ += port->held_too_many();
}

std::shared_ptr<ReaderPort> SubscriberCore::port(TransportKind kind) {
  const std::scoped_lock lock(mutex_);
  return inlets_[static_cast<std::size_t>(kind)].port;
}

/// After something may have been taken from the ports, without a lock.
void SubscriberCore::tell_of_room() {
  if (!writers_wait_.load(std::memory_order_relaxed)) [[likely]]
    return;
  if (const std::shared_ptr<ReaderPort> shm = port(TransportKind::shm)) shm->tell_of_room();
}

std::uint32_t SubscriberCore::depth_by(TransportKind kind) const {
  const bool as_asked = kind == TransportKind::udp || spec_.shm_depth == 0;
  return as_asked ? spec_.options.depth : spec_.shm_depth;
}

/// Whoever waits, wherever.
void SubscriberCore::ring() {
  bell_.ring();
  if (const std::shared_ptr<ReaderPort> udp = udp_port()) udp->interrupt();
}

void SubscriberCore::requests(const FieldMask& mask, std::uint64_t sequence) {
  auto asked = remote_ ? std::make_shared<const detail::ProjectionPlan>(type().type(), mask) : nullptr;
  const std::scoped_lock lock(mutex_);
  requested_ = mask;
  requests_ = sequence;
  asked_ = std::move(asked);
}

bool SubscriberCore::keeps_promises(EndpointId writer, std::uint64_t deadlines_missed, bool alive) {
  const std::scoped_lock lock(mutex_);
  Heard& h = heard(writer);
  const bool is_news = h.deadlines_missed != deadlines_missed || h.alive != alive;
  h.deadlines_missed = deadlines_missed;
  h.alive = alive;
  return is_news;
}

void SubscriberCore::restarted(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  ++heard(writer).restarts;
}

std::uint64_t SubscriberCore::arrivals(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  std::uint64_t sum = 0;
  for (const Inlet& inlet : inlets_) sum += inlet.port == nullptr ? 0 : inlet.port->arrivals(writer);
  return sum;
}

Account::OfReader SubscriberCore::account_of(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  const auto known = std::ranges::find(heard_, writer, &Heard::writer);
  if (known == heard_.end()) return {};
  return {.received = known->received, .lost = known->lost};
}

void SubscriberCore::hears(const std::vector<Hearing>& hearing) {
  hear(hearing);
  // A writer that was killed between handing over its last sample and waking us did not wake us.
  ring();
}

void SubscriberCore::hear(const std::vector<Hearing>& hearing) {
  const std::scoped_lock lock(mutex_);
  writers_.clear();
  writers_wait_.store(
      std::ranges::any_of(hearing,
                          [](const Hearing& h) { return h.shm && h.source.reliable && h.source.waits; }),
      std::memory_order_relaxed);
  for (const Hearing& h : hearing) {
    writers_.push_back(h.status);
    writers_.back().depth = depth_by(h.status.transport);
    Heard& from = heard(h.source.writer);
    if (from.since_ns == 0) from.since_ns = realtime_ns();
    from.lifespan_ns = h.offered.lifespan.count();
    if (from.lifespan_ns == 0) from.account.owe(h.owed);  // else nobody knows how many were still to be had
  }
  if (heard_.size() > writers_.size() + gone_writers_kept) forget_the_gone();
}

/// With the mutex held: writers are random per incarnation, and those that are gone do not return.
void SubscriberCore::forget_the_gone() {
  std::erase_if(heard_, [this](const Heard& h) {
    const auto is_it = [&](const WriterStatus& w) { return w.id == h.writer; };
    if (std::any_of(writers_.begin(), writers_.end(), is_it)) return false;
    gone_.received += h.received;
    gone_.lost += h.lost;
    gone_.withheld += h.withheld;
    gone_.expired += h.expired;
    gone_.restarts += h.restarts;
    return true;
  });
}

/// With the mutex held: whether any inlet has a sample.
bool SubscriberCore::fill_inlets() {
  bool any = false;
  for (Inlet& inlet : inlets_) {
    if (!inlet.next && inlet.port != nullptr) inlet.next = inlet.port->take();
    any |= static_cast<bool>(inlet.next);
  }
  return any;
}

/// Of one writer the lower sequence goes first, whatever the path; between writers, what was sent first.
SubscriberCore::Inlet* SubscriberCore::oldest_inlet() {
  Inlet* oldest = nullptr;
  for (Inlet& inlet : inlets_) {
    if (!inlet.next) continue;
    if (oldest == nullptr) {
      oldest = &inlet;
      continue;
    }
    const SampleBuffer& a = *oldest->next;
    const SampleBuffer& b = *inlet.next;
    const bool earlier =
        a.writer == b.writer ? b.sequence < a.sequence : b.source_stamp_ns < a.source_stamp_ns;
    if (earlier) oldest = &inlet;
  }
  return oldest;
}

SubscriberCore::Heard& SubscriberCore::heard(EndpointId writer) {
  const auto known =
      std::find_if(heard_.begin(), heard_.end(), [&](const Heard& h) { return h.writer == writer; });
  if (known != heard_.end()) return *known;
  Heard& added = heard_.emplace_back();
  added.writer = writer;
  added.account.ask(min_period_us_);
  return added;
}

TransportKind SubscriberCore::transport_of(const Inlet& inlet) const {
  const bool by_udp = &inlet == &inlets_[static_cast<std::size_t>(TransportKind::udp)];
  return by_udp ? TransportKind::udp : TransportKind::shm;
}

/// With the mutex held: the oldest one, in the order of each writer, although one path may be ahead of the
/// other; null if there is none, or none yet.
SubscriberCore::Inlet* SubscriberCore::next_inlet() {
  Inlet* const inlet = oldest_inlet();
  if (inlet == nullptr || follows(*inlet)) return inlet;
  if (transport_of(*inlet) == TransportKind::udp) return &in_turn(*inlet);
  if (!waits(*inlet)) return inlet;
  holds_back_ = true;
  // Behind others that came by UDP there may be the one that is waited for.
  Inlet& udp = inlets_[static_cast<std::size_t>(TransportKind::udp)];
  return udp.next ? &in_turn(udp) : nullptr;
}

bool SubscriberCore::follows(const Inlet& inlet) {
  return heard(inlet.next->writer).account.follows(numbered(inlet));
}

/// With the mutex held: what came by UDP, or what its writer sent before that and lies in shared memory
/// behind samples of other writers.
SubscriberCore::Inlet& SubscriberCore::in_turn(Inlet& udp) {
  const Inlet& shm = inlets_[static_cast<std::size_t>(TransportKind::shm)];
  Inlet& earlier = inlets_[out_of_turn];
  const EndpointId writer = udp.next->writer;
  const bool is_next_there = shm.next && shm.next->writer == writer;
  if (!follows(udp) && !earlier.next && !is_next_there && shm.port != nullptr)
    earlier.next = shm.port->take_of(writer);
  const bool is_earlier =
      earlier.next && earlier.next->writer == writer && earlier.next->sequence < udp.next->sequence;
  return is_earlier ? earlier : udp;
}

/// With the mutex held: whether one before this sample went by UDP and may still come to us. It does not, if
/// a later one did, or if we were not there yet. Both clocks are this host's; if it is set meanwhile, nobody
/// waits.
bool SubscriberCore::waits(const Inlet& inlet) {
  const SampleBuffer& buffer = *inlet.next;
  const Numbered diverted{.sequence = buffer.diverted_sequence, .stamp_ns = buffer.diverted_stamp_ns};
  const Heard& from = heard(buffer.writer);
  const bool was_diverted = diverted.sequence < buffer.sequence && diverted.stamp_ns >= from.since_ns &&
                            from.account.is_new(diverted) && from.account.allows(diverted);
  // Where others were served in shared memory all the time, nothing tells that those before it went to us by
  // UDP, but that so did the last that came.
  if (!was_diverted && !from.by_udp) return false;
  const std::int64_t age_ns = realtime_ns() - (was_diverted ? diverted.stamp_ns : buffer.source_stamp_ns);
  if (age_ns < 0 || age_ns >= spec_.diverted_patience.count()) return false;
  const Inlet& udp = inlets_[static_cast<std::size_t>(TransportKind::udp)];
  if (udp.next && udp.next->writer == buffer.writer) return false;
  return udp.port != nullptr && udp.port->connected(buffer.writer);
}

void SubscriberCore::look_again() {
  {
    const std::scoped_lock lock(mutex_);
    if (!std::exchange(holds_back_, false)) return;
  }
  ring();  // for callbacks, too: those are the dispatcher's
}

/// Whatever came by UDP is for us, its writer saw to that.
Numbered SubscriberCore::numbered(const Inlet& inlet) const {
  const SampleBuffer& buffer = *inlet.next;
  return {.sequence = buffer.sequence,
          .stamp_ns = buffer.source_stamp_ns,
          .gated = transport_of(inlet) == TransportKind::udp,
          .min_period_us = buffer.min_period_us,
          .ordinal = buffer.ordinal,
          .oldest_retained = buffer.oldest_retained,
          .numbering = buffer.numbering};
}

void SubscriberCore::enter(Heard& from, const Numbered& sample, TransportKind by) {
  const SequenceAccount::Missing missing = from.account.enter(sample);
  from.lost += missing.lost;
  from.lost_untold += missing.lost;
  losses_.fetch_add(missing.lost, std::memory_order_relaxed);
  from.withheld += missing.withheld;
  from.by_udp = by == TransportKind::udp;
}

bool SubscriberCore::is_expired(const Heard& from, const Numbered& sample) {
  return from.lifespan_ns != 0 && is_older(sample.stamp_ns, from.lifespan_ns, realtime_ns());
}

/// With the mutex held: drops what is not to be delivered, until the next sample in order is; null if there
/// is none.
SubscriberCore::Inlet* SubscriberCore::find_next() {
  while (fill_inlets()) {
    Inlet* const next = next_inlet();
    if (next == nullptr) return nullptr;
    Inlet& inlet = *next;
    Heard& from = heard(inlet.next->writer);
    const Numbered sample = numbered(inlet);
    const bool is_new = from.account.is_new(sample);  // or it came by both paths while they were switched
    const bool is_ours = is_new && from.account.allows(sample);
    const bool expired = is_ours && is_expired(from, sample);
    if (is_ours && !expired) return next;
    is_new ? enter(from, sample, transport_of(inlet)) : from.account.refuse(sample);
    if (expired) ++from.expired;
    inlet.next.reset();
  }
  return nullptr;
}

/// With the mutex held: the next sample in order, which is thereby taken; empty if there is none.
SubscriberCore::Next SubscriberCore::next() {
  Inlet* const found = find_next();
  if (found == nullptr) return {};
  Inlet& inlet = *found;
  const Numbered sample = numbered(inlet);
  Heard& from = heard(inlet.next->writer);
  enter(from, sample, transport_of(inlet));
  using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;
  const SampleInfo info{.sequence = sample.sequence,
                        .writer = from.writer,
                        .source_stamp = Stamp(std::chrono::nanoseconds(sample.stamp_ns)),
                        .receive_stamp = Stamp(std::chrono::nanoseconds(inlet.next->receive_stamp_ns)),
                        .lost_before = std::exchange(from.lost_untold, 0),
                        .transport = transport_of(inlet)};
  Next taken{std::move(inlet.next), info, info.transport == TransportKind::shm ? asked_ : nullptr};
  if (taken.asked == nullptr) ++from.received;
  return taken;
}

/// With the mutex held: the same, and those before it are passed over.
SubscriberCore::Next SubscriberCore::newest() {
  Next latest = next();
  for (Next other = next(); other.sample; other = next()) {
    if (is_newer(other.info, latest.info)) std::swap(latest, other);
    Heard& from = heard(other.info.writer);
    if (other.asked != nullptr) ++from.received;
    from.lost_untold += other.info.lost_before;  // told with the next one of that writer
  }
  if (latest.sample) latest.info.lost_before += std::exchange(heard(latest.info.writer).lost_untold, 0);
  return latest;
}

template <class Choose>
detail::untyped::Sample SubscriberCore::take(Choose choose) {
  for (;;) {
    Next next;
    {
      const std::scoped_lock lock(mutex_);
      next = choose();
    }
    tell_of_room();
    if (spec_.poll_handle != nullptr) settle_descriptor();
    if (!next.sample) return {};
    if (next.asked == nullptr || as_remote(next)) return wrap(std::move(next));
  }
}

detail::untyped::Sample SubscriberCore::take() {
  return take([this] { return next(); });
}

detail::untyped::Sample SubscriberCore::take_latest() {
  return take([this] { return newest(); });
}

/// After something was taken: the file descriptor is not to be readable any more if that was all.
void SubscriberCore::settle_descriptor() {
  if (available()) return;
  spec_.poll_handle->lower();
  if (available()) spec_.poll_handle->raise();
}

/// Leaves it only what was asked for, and counts it by now. False if it is lost, as it would be there.
bool SubscriberCore::as_remote(Next& next) {
  {
    const std::scoped_lock lock(remote_mutex_);
    next.sample = remote_->of(std::move(next.sample), *next.asked);
  }
  const std::scoped_lock lock(mutex_);
  Heard& from = heard(next.info.writer);
  if (next.sample) {
    ++from.received;
    return true;
  }
  ++from.lost;
  losses_.fetch_add(1, std::memory_order_relaxed);
  from.lost_untold += next.info.lost_before + 1;
  return false;
}

detail::untyped::Sample SubscriberCore::wrap(Next next) {
  return detail::untyped::Sample(next.sample.release(), *spec_.type, next.info,
                                 recorder_ == nullptr ? nullptr : recorder_->begin());
}

bool SubscriberCore::available() {
  bool found = false;
  {
    const std::scoped_lock lock(mutex_);
    found = find_next() != nullptr;
  }
  tell_of_room();
  return found;
}

Result<void> SubscriberCore::set_max_rate_hz(double max_rate_hz) {
  const Result<std::uint32_t> period = min_period_us_of(max_rate_hz);
  if (!period) return tl::unexpected(period.error());
  {
    const std::scoped_lock lock(mutex_);
    min_period_us_ = *period;
    for (Heard& h : heard_) h.account.ask(*period);
  }
  spec_.rate_changed();
  return {};
}

std::uint32_t SubscriberCore::min_period_us() {
  const std::scoped_lock lock(mutex_);
  return min_period_us_;
}

bool SubscriberCore::waits_for_dispatch() {
  // In this order: what is there by now, settle_descriptor() sees once it has lowered the handle.
  if (spec_.poll_handle != nullptr) return available() && !spec_.poll_handle->is_raised();
  return pending_.load() == 0 && !closed_.load() && available();
}

bool SubscriberCore::wait(std::chrono::nanoseconds timeout) { return wait_until(deadline_after(timeout)); }

bool SubscriberCore::wait_until(std::chrono::steady_clock::time_point deadline) {
  const auto now = Clock::now();
  const std::chrono::nanoseconds spin = spins_.load(std::memory_order_relaxed) ? spec_.options.spin : 0ns;
  const auto spin_until = deadline - now < spin ? deadline : now + spin;
  for (;;) {
    const std::uint32_t seen = bell_.rings.load(std::memory_order_seq_cst);
    const bool found = available();
    if (found || Clock::now() >= deadline) {
      if (found || spin_until < deadline) spins_.store(found, std::memory_order_relaxed);
      return found;
    }
    const std::shared_ptr<ReaderPort> udp = udp_port();
    if (udp != nullptr && udp->receive({bell_, seen, deadline, spin_until})) continue;
    if (spec_.poll_handle == nullptr && bell_.spin(seen, spin_until)) continue;
    sleep_until(deadline);
  }
}

void SubscriberCore::sleep_until(std::chrono::steady_clock::time_point deadline) {
  if (spec_.poll_handle == nullptr) {
    bell_.wait(deadline, [this] { return available(); });
  } else {  // the doorbell is shared with others, and not rung for all there is
    settle_descriptor();
    spec_.poll_handle->wait(deadline);
  }
}

void SubscriberCore::arrived() noexcept {
  if (has_callback() && !is_slow_.load()) {
    dispatch(Caller::transport);
  } else if (spec_.poll_handle != nullptr) {
    spec_.poll_handle->raise();
  } else {
    bell_.ring();
  }
}

void SubscriberCore::dispatch() {
  if (spec_.poll_handle == nullptr) return dispatch(Caller::dispatcher);
  if (available()) spec_.poll_handle->raise();
}

void SubscriberCore::dispatch(Caller caller) {
  if (pending_.fetch_add(1) != 0) return;  // whoever is at it sees the count
  for (std::uint32_t seen = 1;;) {
    if (!call_back_for_all(caller)) {
      pending_.store(0);
      bell_.ring();  // the dispatcher looks for itself what there is
      break;
    }
    const std::uint32_t before = pending_.fetch_sub(seen);
    if (before != seen) {
      seen = before - seen;
      continue;
    }
    // Whoever looked while it was not yet zero left a sample to us that we had not seen.
    if (closed_.load() || !available() || pending_.fetch_add(1) != 0) break;
    seen = 1;
  }
  pending_.notify_all();
}

/// False if the rest is for the dispatcher.
bool SubscriberCore::call_back_for_all(Caller caller) {
  dispatching_.store(std::this_thread::get_id());
  bool goes_on = true;
  Now time = Clock::now();
  while (goes_on && !closed_.load()) {
    detail::untyped::Sample sample = take();
    if (!sample) break;
    time = call_back(std::move(sample), time);
    goes_on = caller == Caller::dispatcher || !is_slow_.load();
  }
  dispatching_.store({});
  return goes_on;
}

/// Returns when it was done. `before`: when the one before was, or the first of them was looked for. Taking
/// the sample counts, which takes no time beside a slow callback, and saves a look at the clock.
SubscriberCore::Now SubscriberCore::call_back(detail::untyped::Sample sample, Now before) {
  ++callback_depth;
  spec_.callback(std::move(sample));
  --callback_depth;
  const Now done = Clock::now();
  quick_in_a_row_ = done - before < slow_callback ? quick_in_a_row_ + 1 : 0;
  if (quick_in_a_row_ == 0 || quick_in_a_row_ == quick_again_after) is_slow_.store(quick_in_a_row_ == 0);
  return done;
}

void SubscriberCore::close() {
  closed_.store(true);
  events_.close();
  while (const std::uint32_t pending = pending_.load()) {
    if (dispatching_.load() == std::this_thread::get_id()) return;
    pending_.wait(pending);
  }
}

Requirements SubscriberCore::requirements() {
  FieldMask requested;
  {
    const std::scoped_lock lock(mutex_);
    requested = requested_;
  }
  return recorder_ == nullptr ? declared_requirements(type(), requested)
                              : recorded_requirements(type(), requested, *recorder_);
}

std::uint64_t SubscriberCore::held_too_many() {
  const std::scoped_lock lock(mutex_);
  return sum_of_held_too_many();
}

/// With the mutex held.
std::uint64_t SubscriberCore::sum_of_held_too_many() const {
  std::uint64_t sum = held_too_many_before_;
  for (const Inlet& inlet : inlets_) sum += inlet.port == nullptr ? 0 : inlet.port->held_too_many();
  return sum;
}

SubscriberStatus SubscriberCore::status() {
  const std::scoped_lock lock(mutex_);
  SubscriberStatus status{.received = gone_.received,
                          .lost = gone_.lost,
                          .withheld = gone_.withheld,
                          .expired = gone_.expired,
                          .discarded = discarded_before_,
                          .held_too_many = sum_of_held_too_many(),
                          .mask = requested_,
                          .max_rate_hz = min_period_us_ == 0 ? 0 : 1e6 / min_period_us_,
                          .requests = requests_,
                          .restarts = gone_.restarts,
                          .writers = writers_};
  for (const Inlet& inlet : inlets_) {
    if (inlet.port == nullptr) continue;
    status.lost += inlet.port->lost_unnoticed();
    status.discarded += inlet.port->discarded();
  }
  for (const Heard& h : heard_) {
    status.received += h.received;
    status.lost += h.lost;
    status.withheld += h.withheld;
    status.expired += h.expired;
    status.restarts += h.restarts;
    for (WriterStatus& w : status.writers) {
      if (w.id != h.writer) continue;
      w.received = h.received;
      w.lost = h.lost;
      w.withheld = h.withheld;
      w.expired = h.expired;
      w.deadlines_missed = h.deadlines_missed;
      w.restarts = h.restarts;
      if (h.alive || !w.alive) continue;
      w.alive = false;
      w.reason = "no sign of life within its lease";
    }
  }
  return status;
}

}  // namespace sft::core
