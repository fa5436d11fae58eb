#include "core/node/callback_monitor.h"

namespace sft::core {

namespace {
constexpr int looks_in_callback_max = 4;
}

CallbackMonitor::LongWaits CallbackMonitor::look(Time now) {
  if (!core_->has_callback()) return {};
  const std::uint64_t turns = core_->turns();
  const LongWaits waits{.of_sample = of_sample_.look(core_->waits_for_dispatch(), turns, now),
                        .of_receiver = of_receiver_.look(core_->holds_up_receiver(), turns, now)};
  if (waits.of_sample) core_->feed().waited_long();
  return waits;
}

bool CallbackMonitor::is_in_long_callback() {
  looks_in_callback_ = core_->is_called_back() ? looks_in_callback_ + 1 : 0;
  return looks_in_callback_ >= looks_in_callback_max;
}

}  // namespace sft::core
