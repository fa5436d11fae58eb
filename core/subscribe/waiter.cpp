#include "core/subscribe/waiter.h"

#include <algorithm>

namespace sft::core {

using Clock = std::chrono::steady_clock;

bool Waiter::available() const { return std::ranges::any_of(ports_, &SubscriberPorts::available); }

/// Returns a port of the network, or null if there is none. Any such port receives for all ports of its node.
std::shared_ptr<NetworkReader> Waiter::receiver() const {
  for (SubscriberPorts* const ports : ports_) {
    if (std::shared_ptr<NetworkReader> network = ports->network()) return network;
  }
  return nullptr;
}

bool Waiter::wait_until(Time deadline) {
  if (available()) return true;
  const Time began = Clock::now();
  const std::chrono::nanoseconds spin = spinning_.spin(spin_);
  const Time spin_until = deadline - began < spin ? deadline : began + spin;
  for (;;) {
    const std::uint32_t seen = bell_.rings.load(std::memory_order_seq_cst);
    const bool found = available();
    const Time now = Clock::now();
    if (found || now >= deadline || is_interrupted()) {
      spinning_.waited(now - began, found, spin_);
      return found;
    }
    const std::shared_ptr<NetworkReader> network = receiver();
    if (network != nullptr && network->receive({bell_, seen, deadline, spin_until})) continue;
    if (handle_ == nullptr && bell_.spin(seen, spin_until)) continue;
    sleep_until(deadline);
  }
}

void Waiter::sleep_until(Time deadline) {
  if (handle_ == nullptr) {
    bell_.wait(deadline, [this] { return must_return(); });
  } else {  // the doorbell is shared with other subscribers, and is not rung for each sample
    settle();
    handle_->wait(deadline);
  }
}

void Waiter::sample_arrived() { handle_ != nullptr ? handle_->raise() : bell_.ring(); }

int Waiter::descriptor() const {
  if (handle_ == nullptr) return -1;
  // A thread that took the last sample before this exchange may have left the descriptor readable.
  if (!is_watched_.exchange(true, std::memory_order_seq_cst)) settle();
  return handle_->descriptor();
}

void Waiter::show_if_available() const {
  if (must_return()) handle_->raise();
}

void Waiter::settle() const {
  if (must_return()) return;
  handle_->lower();
  show_if_available();
}

}  // namespace sft::core
