#include "core/report/callback_thread.h"

#include <chrono>
#include <utility>

namespace sft::core {

Result<void> CallbackThread::start() {
  const auto nothing_to_do = [] { return std::chrono::milliseconds(std::chrono::hours(1)); };
  const Lock lock(mutex_);
  if (is_started_) return {};
  Result<void> started = agent_.start(spec_, {.tick = nothing_to_do, .idle = nothing_to_do});
  is_started_ = started.has_value();
  return started;
}

void CallbackThread::post(Agent::Task call) {
  if (waiting_.fetch_add(1) >= waiting_max) {
    waiting_.fetch_sub(1);
    left_out_.fetch_add(1);
    return;
  }
  agent_.post([this, call = std::move(call)] {
    waiting_.fetch_sub(1);
    call();
  });
}

std::uint64_t CallbackThread::take_left_out() {
  return waiting_.load() >= waiting_max ? 0 : left_out_.exchange(0);
}

}  // namespace sft::core
