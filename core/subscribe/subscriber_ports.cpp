#include "core/subscribe/subscriber_ports.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void SubscriberPorts::Counts::add(const ReaderPort& port) {
  lost += port.lost_unnoticed();
  discarded += port.discarded();
  held_too_many += port.held_too_many();
}

void SubscriberPorts::set(TransportKind kind, std::shared_ptr<ReaderPort> port) {
  const std::shared_ptr<ReaderPort> by_udp = udp();
  if (kind == TransportKind::shm && port != nullptr && by_udp != nullptr) by_udp->share_reader();
  const std::scoped_lock lock(mutex_);
  // The former port ends with the argument, after the mutex was released.
  ports_[static_cast<std::size_t>(kind)].swap(port);
  if (port != nullptr) of_former_ports_.add(*port);
}

std::shared_ptr<ReaderPort> SubscriberPorts::port(TransportKind kind) {
  const std::scoped_lock lock(mutex_);
  return ports_[static_cast<std::size_t>(kind)];
}

/// Called without the mutex after samples may have been taken: the port may make a system call.
void SubscriberPorts::tell_of_room() {
  if (!writers_wait_.load(std::memory_order_relaxed)) [[likely]]
    return;
  if (const std::shared_ptr<ReaderPort> shm = port(TransportKind::shm)) shm->tell_of_room();
}

void SubscriberPorts::fill(Intake::Inlet inlet, TransportKind kind) {
  ReaderPort* const port = at(kind);
  if (port != nullptr && intake_.is_empty(inlet)) intake_.put(inlet, port->take());
}

/// With the mutex held: true if intake_ can deliver a sample.
bool SubscriberPorts::find_next() {
  using Decision = Intake::Decision;
  LazyRealtime now;
  Decision decision = Decision::dropped;
  for (;;) {
    switch (decision) {
      case Decision::deliver:
        return true;
      case Decision::nothing:
        return false;
      case Decision::dropped:
        fill(Intake::Inlet::shm, TransportKind::shm);
        fill(Intake::Inlet::udp, TransportKind::udp);
        if (intake_.is_empty()) return false;
        decision = intake_.next(now);
        break;
      case Decision::ask_connected: {
        const ReaderPort* const udp = at(TransportKind::udp);
        decision = intake_.connected(udp != nullptr && udp->connected(intake_.asked_about()), now);
        break;
      }
      case Decision::ask_overtaken: {
        ReaderPort* const shm = at(TransportKind::shm);
        decision =
            intake_.overtaken(shm == nullptr ? SampleHandle() : shm->take_of(intake_.asked_about()), now);
        break;
      }
    }
  }
}

/// With the mutex held.
SubscriberPorts::Next SubscriberPorts::next() {
  if (!find_next()) return {};
  Next next{intake_.take(), nullptr};
  if (next.info.transport == TransportKind::shm) next.asked = asked_;
  return next;
}

SubscriberPorts::Next SubscriberPorts::take() {
  std::unique_lock lock(mutex_);
  Next taken = next();
  lock.unlock();
  tell_of_room();
  return taken;
}

SubscriberPorts::Next SubscriberPorts::take_latest() {
  std::unique_lock lock(mutex_);
  Next latest = next();
  while (latest.sample && find_next()) intake_.keep_newer(latest, intake_.take());
  if (latest.sample) intake_.report_losses(latest);
  latest.asked = latest.sample && latest.info.transport == TransportKind::shm ? asked_ : nullptr;
  lock.unlock();
  tell_of_room();
  return latest;
}

bool SubscriberPorts::available() {
  bool found = false;
  {
    const std::scoped_lock lock(mutex_);
    found = find_next();
  }
  tell_of_room();
  return found;
}

void SubscriberPorts::copied(const SampleInfo& info, bool is_delivered) {
  const std::scoped_lock lock(mutex_);
  intake_.copied(info, is_delivered);
}

void SubscriberPorts::ask(std::uint32_t min_period_us) {
  const std::scoped_lock lock(mutex_);
  intake_.accounts().ask(min_period_us);
}

std::uint32_t SubscriberPorts::min_period_us() {
  const std::scoped_lock lock(mutex_);
  return intake_.accounts().min_period_us();
}

FieldMask SubscriberPorts::requested() {
  const std::scoped_lock lock(mutex_);
  return requested_;
}

void SubscriberPorts::hears(const std::vector<Hearing>& hearing) {
  const auto waits = [](const Hearing& h) { return h.shm && h.source.reliable && h.source.waits; };
  const std::scoped_lock lock(mutex_);
  writers_wait_.store(std::ranges::any_of(hearing, waits), std::memory_order_relaxed);
  intake_.accounts().hears(hearing, realtime_ns());
}

void SubscriberPorts::requests(const FieldMask& mask, std::uint64_t sequence,
                               std::shared_ptr<const detail::ProjectionPlan> asked) {
  const std::scoped_lock lock(mutex_);
  requested_ = mask;
  requests_ = sequence;
  asked_ = std::move(asked);
}

bool SubscriberPorts::keeps_promises(EndpointId writer, std::uint64_t deadlines_missed, bool alive) {
  const std::scoped_lock lock(mutex_);
  return intake_.accounts().keeps_promises(writer, deadlines_missed, alive);
}

void SubscriberPorts::restarted(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  ++intake_.accounts().of(writer).restarts;
}

bool SubscriberPorts::take_held_back() {
  const std::scoped_lock lock(mutex_);
  return intake_.take_held_back();
}

std::uint64_t SubscriberPorts::losses() {
  const std::scoped_lock lock(mutex_);
  return intake_.accounts().losses();
}

std::uint64_t SubscriberPorts::held_too_many() {
  const std::scoped_lock lock(mutex_);
  std::uint64_t sum = of_former_ports_.held_too_many;
  for (const auto& port : ports_) sum += port == nullptr ? 0 : port->held_too_many();
  return sum;
}

std::uint64_t SubscriberPorts::arrivals(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& port : ports_) sum += port == nullptr ? 0 : port->arrivals(writer);
  return sum;
}

Account::OfReader SubscriberPorts::account_of(EndpointId writer) {
  const std::scoped_lock lock(mutex_);
  const WriterAccounts::Writer* const known = intake_.accounts().find(writer);
  if (known == nullptr) return {};
  return {.received = known->received, .lost = known->lost};
}

/// With the mutex held.
SubscriberPorts::Counts SubscriberPorts::counts() const {
  Counts counts = of_former_ports_;
  for (const auto& port : ports_) {
    if (port != nullptr) counts.add(*port);
  }
  return counts;
}

SubscriberStatus SubscriberPorts::status() {
  const std::scoped_lock lock(mutex_);
  SubscriberStatus status;
  intake_.accounts().describe(status);
  const Counts counts = this->counts();
  status.lost += counts.lost;
  status.discarded = counts.discarded;
  status.held_too_many = counts.held_too_many;
  status.mask = requested_;
  status.requests = requests_;
  return status;
}

}  // namespace sft::core
