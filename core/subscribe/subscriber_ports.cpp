#include "core/subscribe/subscriber_ports.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void SubscriberPorts::Counts::add(const ReaderPort::Counters& counters) {
  lost += counters.lost_unnoticed;
  discarded += counters.discarded;
}

void SubscriberPorts::Counts::add(const std::shared_ptr<BorrowingReader>& port) {
  if (port == nullptr) return;
  add(*port);
  held_too_many += port->held_too_many();
}

void SubscriberPorts::set_memory(std::shared_ptr<BorrowingReader> port) {
  const std::shared_ptr<NetworkReader> beside = network();
  if (port != nullptr && beside != nullptr) beside->share_reader();
  const Lock lock(mutex_);
  memory_.swap(port);  // the argument destroys the former port after the mutex is unlocked
  of_former_ports_.add(port);
}

void SubscriberPorts::lose_memory() {
  std::shared_ptr<BorrowingReader> ended;  // destroyed after the mutex is unlocked
  const Lock lock(mutex_);
  if (memory_ == nullptr) return;
  ended = std::exchange(lost_memory_, std::exchange(memory_, nullptr));
  of_former_ports_.add(ended);
}

bool SubscriberPorts::release_lost_memory(bool also_if_some_wait) {
  std::shared_ptr<BorrowingReader> ended;  // destroyed after the mutex is unlocked
  const Lock lock(mutex_);
  if (lost_memory_ != nullptr && (also_if_some_wait || !lost_memory_->some_wait()))
    ended = std::exchange(lost_memory_, nullptr);
  of_former_ports_.add(ended);
  return lost_memory_ == nullptr;
}

void SubscriberPorts::set_network(std::shared_ptr<NetworkReader> port) {
  const Lock lock(mutex_);
  network_.swap(port);  // the argument destroys the former port, as in set_memory()
  if (port != nullptr) of_former_ports_.add(*port);
}

void SubscriberPorts::set_vanilla(std::shared_ptr<VanillaInlet> inlet) {
  if (const std::shared_ptr<NetworkReader> beside = network()) beside->share_reader();
  const Lock lock(mutex_);
  vanilla_ = std::move(inlet);
}

std::shared_ptr<NetworkReader> SubscriberPorts::network() {
  const Lock lock(mutex_);
  return network_;
}

void SubscriberPorts::notify_room() {
  if (!writers_wait_.load(std::memory_order_relaxed)) [[likely]]
    return;
  std::shared_ptr<BorrowingReader> memory;
  {
    const Lock lock(mutex_);
    memory = memory_;
  }
  if (memory != nullptr) memory->notify_room();
}

template <class Take>
SampleHandle SubscriberPorts::take_from_memory(Take take) {
  SampleHandle sample;
  if (lost_memory_ != nullptr) [[unlikely]]
    sample = take(*lost_memory_);
  if (!sample && memory_ != nullptr) sample = take(*memory_);
  return sample;
}

bool SubscriberPorts::some_wait_in_memory() const {
  return (lost_memory_ != nullptr && lost_memory_->some_wait()) ||
         (memory_ != nullptr && memory_->some_wait());
}

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
        if (intake_.is_empty(Intake::Inlet::memory))
          intake_.put(Intake::Inlet::memory, take_from_memory([](auto& port) { return port.take(); }));
        if (network_ != nullptr && intake_.is_empty(Intake::Inlet::network))
          intake_.put(Intake::Inlet::network, network_->take());
        if (vanilla_ != nullptr && intake_.is_empty(Intake::Inlet::vanilla))
          intake_.put(Intake::Inlet::vanilla, vanilla_->take());
        if (intake_.is_empty()) {
          if (in_force_ && !some_wait_in_memory()) [[unlikely]]
            intake_.accounts().forget_conditions_before(*std::exchange(in_force_, std::nullopt));
          return false;
        }
        decision = intake_.next(now);
        break;
      case Decision::ask_connected: {
        const bool is_connected = network_ != nullptr && network_->connected(intake_.asked_about());
        decision = intake_.connected(is_connected, now);
        break;
      }
      case Decision::ask_overtaken: {
        const EndpointId writer = intake_.asked_about();
        decision =
            intake_.overtaken(take_from_memory([writer](auto& port) { return port.take_of(writer); }), now);
        break;
      }
    }
  }
}

SubscriberPorts::Next SubscriberPorts::next() {
  if (!find_next()) return {};
  Next next{intake_.take()};
  settle(next);
  return next;
}

/// Determines the request for which the sample is delivered. A merged sample does not show its request: it
/// has whole fields, and suits each request without conditions whose fields it has. The present request is
/// tried first.
void SubscriberPorts::settle(Next& next) {
  next.is_copied = intake_.is_copied(next.info.transport);
  if (!next.is_copied && !reports_asked_) return;
  next.asked = asked_;
  if (next.info.transport != TransportKind::udp) return;  // it has all fields
  const auto is_it = [&sample = *next.sample](const auto& asked) {
    const Selection& selection = asked->selection;
    if (sample.merged) return selection.gate().is_open() && sample.mask.contains(selection.mask());
    return selection.parts_hash() == sample.parts && selection.mask() == sample.mask;
  };
  if (is_it(asked_)) return;
  const auto known = std::ranges::find_if(earlier_, is_it);
  if (known != earlier_.end()) next.asked = *known;
}

SubscriberPorts::Next SubscriberPorts::take() {
  Lock lock(mutex_);
  Next taken = next();
  lock.unlock();
  notify_room();
  return taken;
}

SubscriberPorts::Next SubscriberPorts::take_latest() {
  Lock lock(mutex_);
  Next latest = next();
  while (latest.sample && find_next()) intake_.keep_newer(latest, intake_.take());
  if (latest.sample) intake_.report_losses(latest);
  if (latest.sample) settle(latest);
  lock.unlock();
  notify_room();
  return latest;
}

std::optional<SampleOrigin> SubscriberPorts::next_origin() {
  std::optional<SampleOrigin> origin;
  {
    const Lock lock(mutex_);
    if (find_next()) origin = intake_.next_origin();
  }
  notify_room();
  return origin;
}

void SubscriberPorts::copied(const SampleInfo& info, bool is_delivered) {
  const Lock lock(mutex_);
  intake_.copied(info, is_delivered);
}

void SubscriberPorts::ask(std::uint32_t min_period_us) {
  const Lock lock(mutex_);
  intake_.accounts().ask(min_period_us);
}

std::uint32_t SubscriberPorts::min_period_us() {
  const Lock lock(mutex_);
  return intake_.accounts().min_period_us();
}

Selection SubscriberPorts::requested() {
  const Lock lock(mutex_);
  return asked_->selection;
}

void SubscriberPorts::hears(const std::vector<Hearing>& hearing) {
  const auto waits = [](const Hearing& h) { return h.memory && h.source.reliable && h.source.waits; };
  const Lock lock(mutex_);
  writers_wait_.store(std::ranges::any_of(hearing, waits), std::memory_order_relaxed);
  intake_.accounts().hears(hearing, realtime_ns());
}

void SubscriberPorts::requests(std::shared_ptr<const Asked> asked, std::uint64_t sequence) {
  const Lock lock(mutex_);
  requests_ = sequence;
  if (asked == nullptr) return;
  takes_parts_ = takes_parts_ || asked->from_network;
  intake_.copy(asked->plan != nullptr, takes_parts_);
  intake_.accounts().ask_conditions(asked->selection.gate_hash());
  if (asked_ != nullptr) earlier_.insert(earlier_.begin(), std::move(asked_));
  if (earlier_.size() > earlier_max) earlier_.pop_back();
  asked_ = std::move(asked);
}

void SubscriberPorts::forget_former_conditions() {
  const Lock lock(mutex_);
  in_force_ = intake_.accounts().asked_gates().latest();
}

bool SubscriberPorts::keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive) {
  const Lock lock(mutex_);
  return intake_.accounts().keeps_promises(writer, more_missed, alive);
}

void SubscriberPorts::restarted(EndpointId writer) {
  const Lock lock(mutex_);
  ++intake_.accounts().of(writer).restarts;
}

bool SubscriberPorts::take_held_back() {
  const Lock lock(mutex_);
  return intake_.take_held_back();
}

std::uint64_t SubscriberPorts::losses() {
  const Lock lock(mutex_);
  return intake_.accounts().losses();
}

std::uint64_t SubscriberPorts::held_too_many() {
  const Lock lock(mutex_);
  return of_former_ports_.held_too_many + (memory_ == nullptr ? 0 : memory_->held_too_many()) +
         (lost_memory_ == nullptr ? 0 : lost_memory_->held_too_many());
}

std::uint64_t SubscriberPorts::arrivals(EndpointId writer) {
  const Lock lock(mutex_);
  return (memory_ == nullptr ? 0 : memory_->arrivals(writer)) +
         (network_ == nullptr ? 0 : network_->arrivals(writer)) +
         (vanilla_ == nullptr ? 0 : vanilla_->arrivals(writer));
}

DomainSnapshot::Received SubscriberPorts::account_of(EndpointId writer) {
  const Lock lock(mutex_);
  DomainSnapshot::Received account;
  if (vanilla_ != nullptr) account.lost = vanilla_->lost_before_first(writer);
  if (const WriterAccounts::Writer* const known = intake_.accounts().find(writer)) {
    account.received = known->received;
    account.lost += known->lost;
  }
  return account;
}

SubscriberPorts::Counts SubscriberPorts::counts() const {
  Counts counts = of_former_ports_;
  counts.add(memory_);
  counts.add(lost_memory_);
  if (network_ != nullptr) counts.add(*network_);
  if (vanilla_ != nullptr) counts.add(vanilla_->counters());
  return counts;
}

SubscriberStatus SubscriberPorts::status() {
  const Lock lock(mutex_);
  SubscriberStatus status;
  intake_.accounts().describe(status);
  const Counts counts = this->counts();
  status.lost += counts.lost;
  status.discarded = counts.discarded;
  status.held_too_many = counts.held_too_many;
  status.mask = asked_->selection.mask();
  status.selection = asked_->selection;
  status.requests = requests_;
  return status;
}

}  // namespace sft::core
