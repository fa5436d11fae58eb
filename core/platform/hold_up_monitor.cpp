#include "core/platform/hold_up_monitor.h"

#include <utility>

namespace sft::core {

namespace {
thread_local HoldUpMonitor* monitor_of_this_thread = nullptr;
}  // namespace

HoldUpMonitor::HoldUpMonitor(Report report, ReadTime time) : report_(std::move(report)), time_(time) {
  if (report_) monitor_of_this_thread = this;
}

HoldUpMonitor::~HoldUpMonitor() {
  if (report_) monitor_of_this_thread = nullptr;
}

void HoldUpMonitor::begin(std::source_location what) {
  if (!report_) return;
  end();
  piece_ = {what, time_()};
}

void HoldUpMonitor::end() {
  const auto piece = std::exchange(piece_, std::nullopt);
  if (!piece) return;
  const auto held_up = std::chrono::duration_cast<std::chrono::milliseconds>(time_() - piece->since);
  if (held_up > held_up_max) report_(piece->what, held_up);
}

void next_piece_of_work(std::source_location what) {
  if (monitor_of_this_thread != nullptr) monitor_of_this_thread->begin(what);
}

}  // namespace sft::core
