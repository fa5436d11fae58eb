#include "core/node/transport_monitor.h"

#include <algorithm>
#include <utility>

namespace sft::core {

namespace {
constexpr const char* ruled_out = "the node rules it out";
// As long as nothing changes, a look at the addresses costs only one call.
constexpr std::chrono::milliseconds look_at_addresses_every{200};
/// The pause between looks while shared memory may become available, since an obstacle may disappear at any
/// time.
constexpr std::chrono::milliseconds look_for_memory_every{200};
}  // namespace

TransportMonitor::TransportMonitor(SharedMemory* memory, Network* network, std::uint64_t network_id,
                                   NodeLog& log)
    : memory_(memory), network_(network), log_(log) {
  self_.network = network_id;
  self_.memory_state = memory_ == nullptr ? ruled_out : "starting";
  if (network_ == nullptr) return;
  addresses_ = network_->addresses();
  links_ = network_->links();
}

TransportMonitor::MemoryChange TransportMonitor::look_at_memory(Time now) {
  if (memory_ == nullptr) return {};
  Self self = self_;
  memory_availability_ = memory_->poll(now);
  const bool ready = memory_availability_ == Availability::ready;
  self.host = ready ? memory_->host_token() : HostToken{};
  self.memory_state = memory_->description();
  if (ready) self.memory_failure.clear();
  if (memory_availability_ == Availability::unavailable) self.memory_failure = self.memory_state;
  self.may_write_memory = memory_->may_write();
  if (self == self_) return {};
  const MemoryChange change{.any = true,
                            .of_host = self.host != self_.host,
                            .of_state = self.memory_state != self_.memory_state,
                            .of_failure = self.memory_failure != self_.memory_failure};
  self_ = std::move(self);
  memory_ready_.store(ready);
  const Lock lock(memory_state_mutex_);
  memory_state_ = self_.memory_state;
  return change;
}

/// Logs the state of shared memory. An attempt that follows a failed attempt is not logged, but its outcome
/// is. The first failure is logged as a warning, since whole samples are sent by UDP from then on. A
/// missing daemon is no warning if the user does not want a daemon.
void TransportMonitor::log_memory() {
  const bool unavailable = memory_availability_ == Availability::unavailable;
  if (memory_availability_ == Availability::starting && !self_.memory_failure.empty()) return;
  if (unavailable && self_.memory_failure == logged_failure_) return;
  logged_failure_ = self_.memory_failure;
  const bool warns = unavailable && !memory_->lacks_daemon() && !std::exchange(memory_warned_, true);
  log_.write(warns ? LogLevel::warning : LogLevel::info, "shared memory: " + self_.memory_state);
}

/// If the system has stopped a transport, the node cannot repair it. From then on status() reports this.
TransportMonitor::NetworkChange TransportMonitor::look_at_network(Time now) {
  if (network_ == nullptr || network_failed_) return NetworkChange::none;
  const bool is_ready = network_->poll(now) == Availability::ready;
  for (const Network::Remark& remark : network_->take_remarks())
    log_.write(remark.level, "UDP: " + remark.text, now);
  if (is_ready) return look_at_addresses(now);
  network_failed_ = true;
  log_.write(LogLevel::error, "UDP: " + network_->description());
  return NetworkChange::none;
}

Time TransportMonitor::next_look(Time now) const {
  const Time at_network = network_ == nullptr || network_failed_ ? Time::max() : network_->next_poll();
  const bool may_come = memory_ != nullptr && !memory_ready() && !memory_->lacks_daemon();
  return may_come ? std::min(at_network, now + look_for_memory_every) : at_network;
}

TransportMonitor::NetworkChange TransportMonitor::look_at_addresses(Time now) {
  if (now < next_look_at_addresses_) return NetworkChange::none;
  next_look_at_addresses_ = now + look_at_addresses_every;
  if (!network_->network_changed()) return NetworkChange::none;
  std::vector<UdpAddress> addresses = network_->addresses();
  std::vector<Link> links = network_->links();
  const bool moved = addresses != addresses_;
  if (!moved && links == links_) return NetworkChange::none;
  addresses_ = std::move(addresses);
  links_ = std::move(links);
  return moved ? NetworkChange::addresses : NetworkChange::links;
}

std::string TransportMonitor::memory_state() const {
  const Lock lock(memory_state_mutex_);
  return memory_ == nullptr ? ruled_out : memory_state_;
}

}  // namespace sft::core
