#include "core/platform/hold_up_watch.h"

#include <utility>

namespace sft::core {

namespace {
thread_local HoldUpWatch* watch_of_this_thread = nullptr;
}  // namespace

HoldUpWatch::HoldUpWatch(Report report, ReadTime time) : report_(std::move(report)), time_(time) {
  if (report_) watch_of_this_thread = this;
}

HoldUpWatch::~HoldUpWatch() {
  if (report_) watch_of_this_thread = nullptr;
}

void HoldUpWatch::begin(std::source_location what) {
  if (!report_) return;
  end();
  piece_ = {what, time_()};
}

void HoldUpWatch::end() {
  const auto piece = std::exchange(piece_, std::nullopt);
  if (!piece) return;
  const auto held_up = std::chrono::duration_cast<std::chrono::milliseconds>(time_() - piece->since);
  if (held_up > held_up_max) report_(piece->what, held_up);
}

void next_piece_of_work(std::source_location what) {
  if (watch_of_this_thread != nullptr) watch_of_this_thread->begin(what);
}

}  // namespace sft::core
