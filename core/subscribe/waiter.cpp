#include "core/subscribe/waiter.h"

namespace sft::core {

using Clock = std::chrono::steady_clock;

bool Waiter::wait_until(Time deadline) {
  if (ports_.available()) return true;
  const Time began = Clock::now();
  const std::chrono::nanoseconds spin = spinning_.spin();
  const Time spin_until = deadline - began < spin ? deadline : began + spin;
  for (;;) {
    const std::uint32_t seen = bell_.rings.load(std::memory_order_seq_cst);
    const bool found = ports_.available();
    const Time now = Clock::now();
    if (found || now >= deadline) {
      spinning_.waited(now - began, found);
      return found;
    }
    const std::shared_ptr<NetworkReader> network = ports_.network();
    if (network != nullptr && network->receive({bell_, seen, deadline, spin_until})) continue;
    if (handle_ == nullptr && bell_.spin(seen, spin_until)) continue;
    sleep_until(deadline);
  }
}

void Waiter::sleep_until(Time deadline) {
  if (handle_ == nullptr) {
    bell_.wait(deadline, [this] { return ports_.available(); });
  } else {  // the doorbell is shared with other subscribers, and is not rung for every sample
    settle();
    handle_->wait(deadline);
  }
}

void Waiter::wake() {
  bell_.ring();
  if (const std::shared_ptr<NetworkReader> network = ports_.network()) network->interrupt();
}

void Waiter::sample_arrived() { handle_ != nullptr ? handle_->raise() : bell_.ring(); }

void Waiter::tell_if_available() {
  if (ports_.available()) handle_->raise();
}

void Waiter::settle() {
  if (ports_.available()) return;
  handle_->lower();
  tell_if_available();
}

}  // namespace sft::core
