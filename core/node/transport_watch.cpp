#include "core/node/transport_watch.h"

#include <utility>

namespace sft::core {

namespace {
constexpr const char* ruled_out = "the node rules it out";
constexpr std::chrono::milliseconds look_at_addresses_every{200};  // costs one call while nothing changes
}  // namespace

TransportWatch::TransportWatch(Transport* shm, Transport* udp, std::uint64_t network, NodeLog& log)
    : shm_(shm), udp_(udp), log_(log) {
  self_.network = network;
  self_.shm_state = shm_ == nullptr ? ruled_out : "starting";
  if (udp_ == nullptr) return;
  addresses_ = udp_->addresses();
  links_ = udp_->links();
}

TransportWatch::ShmChange TransportWatch::look_at_shm(Time now) {
  if (shm_ == nullptr) return {};
  Self self = self_;
  shm_availability_ = shm_->poll(now);
  const bool ready = shm_availability_ == Availability::ready;
  self.host = ready ? shm_->host_token() : HostToken{};
  self.shm_state = shm_->description();
  self.may_write_shm = shm_->may_write();
  if (self == self_) return {};
  const ShmChange change{
      .any = true, .of_host = self.host != self_.host, .of_state = self.shm_state != self_.shm_state};
  self_ = std::move(self);
  shm_ready_.store(ready);
  const std::scoped_lock lock(shm_state_mutex_);
  shm_state_ = self_.shm_state;
  return change;
}

/// An attempt that follows a failed one is no news, only its outcome is. A program that is to start the
/// daemon and cannot is set up wrongly: that is worth a warning.
void TransportWatch::log_shm() {
  const bool unavailable = shm_availability_ == Availability::unavailable;
  if (shm_availability_ == Availability::starting && !shm_failure_.empty()) return;
  if (unavailable && self_.shm_state == shm_failure_) return;
  shm_failure_ = unavailable ? self_.shm_state : "";
  const bool not_started = shm_failure_.find("could not be started") != std::string::npos;
  const bool warns = not_started && !std::exchange(shm_warned_, true);
  log_.write(warns ? LogLevel::warning : LogLevel::info, "shared memory: " + self_.shm_state);
}

/// A transport that the system has stopped cannot be repaired from within; status() says so from then on.
TransportWatch::NetworkChange TransportWatch::look_at_udp(Time now) {
  if (udp_ == nullptr || udp_failed_) return NetworkChange::none;
  if (udp_->poll(now) == Availability::ready) return look_at_addresses(now);
  udp_failed_ = true;
  log_.write(LogLevel::error, "UDP: " + udp_->description());
  return NetworkChange::none;
}

TransportWatch::NetworkChange TransportWatch::look_at_addresses(Time now) {
  if (now < next_look_at_addresses_) return NetworkChange::none;
  next_look_at_addresses_ = now + look_at_addresses_every;
  if (!udp_->network_changed()) return NetworkChange::none;
  std::vector<UdpAddress> addresses = udp_->addresses();
  std::vector<Link> links = udp_->links();
  const bool moved = addresses != addresses_;
  if (!moved && links == links_) return NetworkChange::none;
  addresses_ = std::move(addresses);
  links_ = std::move(links);
  return moved ? NetworkChange::addresses : NetworkChange::links;
}

std::string TransportWatch::shm_state() const {
  const std::scoped_lock lock(shm_state_mutex_);
  return shm_ == nullptr ? ruled_out : shm_state_;
}

}  // namespace sft::core
