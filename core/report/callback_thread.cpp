#include "core/report/callback_thread.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sft::core {

Result<void> CallbackThread::start() {
  const auto nothing_to_do = [] { return std::chrono::milliseconds(std::chrono::hours(1)); };
  const Lock lock(start_mutex_);
  if (is_started_) return {};
  Result<void> started = agent_.start(spec_, {.tick = nothing_to_do, .idle = nothing_to_do});
  is_started_ = started.has_value();
  return started;
}

void CallbackThread::post(const void* source, Agent::Task call) {
  {
    const Lock lock(mutex_);
    std::deque<Agent::Task>& calls = waiting_[source];
    if (calls.size() >= waiting_max) {
      ++left_out_;
      return;
    }
    if (calls.empty()) turns_.push_back(source);
    calls.push_back(std::move(call));
  }
  agent_.post([this] { call_next(); });
}

/// Calls the first call of the source whose turn it is. A source with further calls waits until each other
/// source has had its turn.
void CallbackThread::call_next() {
  Agent::Task call;
  {
    const Lock lock(mutex_);
    const auto turn = waiting_.find(turns_.front());
    turns_.pop_front();
    call = std::move(turn->second.front());
    turn->second.pop_front();
    if (turn->second.empty()) {
      waiting_.erase(turn);
    } else {
      turns_.push_back(turn->first);
    }
  }
  in_call_ = true;
  call();
  call = nullptr;  // what the call captured may be the last handle of a node
  in_call_ = false;
}

std::uint64_t CallbackThread::take_left_out() {
  const Lock lock(mutex_);
  const auto is_full = [](const auto& source) { return source.second.size() >= waiting_max; };
  return std::ranges::any_of(waiting_, is_full) ? 0 : std::exchange(left_out_, 0);
}

}  // namespace sft::core
