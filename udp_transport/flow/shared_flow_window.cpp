#include "udp_transport/flow/shared_flow_window.h"

#include <utility>

namespace sft::udp {

SharedFlowWindow::SharedFlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret,
                                   std::shared_ptr<UnprovenBudget> host)
    : asks_(limits.asks), window_(flow, limits, secret, std::move(host)), answers_(!limits.asks) {}

void SharedFlowWindow::announce(std::uint32_t receive_buffer_bytes) {
  receive_buffer_bytes_.store(receive_buffer_bytes, std::memory_order_relaxed);
  const core::Lock lock(mutex_);
  window_.announce(receive_buffer_bytes);
}

void SharedFlowWindow::note_answers(Time now) {
  answers_.store(window_.answers(now), std::memory_order_relaxed);
}

std::size_t SharedFlowWindow::room(Size size, Time now) {
  const core::Lock lock(mutex_);
  const std::size_t room = window_.room(size, now);
  if (room == 0) note_answers(now);
  return room;
}

std::size_t SharedFlowWindow::batch_bytes() const {
  const core::Lock lock(mutex_);
  return window_.batch_bytes();
}

SharedFlowWindow::Time SharedFlowWindow::next_ready(Time now) const {
  const core::Lock lock(mutex_);
  return window_.next_ready(now);
}

std::uint64_t SharedFlowWindow::position() const {
  const core::Lock lock(mutex_);
  return window_.position();
}

bool SharedFlowWindow::passed(std::uint64_t position) const {
  const core::Lock lock(mutex_);
  return window_.passed(position);
}

SharedFlowWindow::Time::duration SharedFlowWindow::round_trip() const {
  const core::Lock lock(mutex_);
  return window_.round_trip();
}

bool SharedFlowWindow::is_mute(Time now) const {
  const core::Lock lock(mutex_);
  return window_.is_mute(now);
}

bool SharedFlowWindow::takes_control(Time now) {
  const core::Lock lock(mutex_);
  const bool takes = window_.takes_control(now);
  control_withheld_ = control_withheld_ || !takes;
  return takes;
}

std::optional<FlowMark> SharedFlowWindow::sent(std::size_t bytes, std::size_t datagrams, std::size_t longest,
                                               Time now, bool aside) {
  const core::Lock lock(mutex_);
  window_.sent(bytes, datagrams, now, aside);
  if (asks_) lengths_.sent(longest, now);
  return mark(now);
}

std::optional<FlowMark> SharedFlowWindow::mark(Time now) {
  const std::optional<FlowMark> mark = window_.mark(now, lengths_.is_uncertain());
  if (mark) lengths_.mark(mark->position);
  return mark;
}

std::optional<FlowMark> SharedFlowWindow::await_room(Time now) {
  const core::Lock lock(mutex_);
  window_.await_room();
  return mark(now);
}

SharedFlowWindow::Heard SharedFlowWindow::hear(const FlowReport& report, Time now) {
  const core::Lock lock(mutex_);
  if (!window_.answers_a_mark(report)) return {};
  const bool goes_on = window_.hear(report, now);
  note_answers(now);
  return {.accepted = true,
          .goes_on = goes_on,
          .control_was_withheld = std::exchange(control_withheld_, false),
          .lost_length = lengths_.evaluate(report, window_.marked_at(report))};
}

void SharedFlowWindow::lives(Time now) {
  const core::Lock lock(mutex_);
  window_.lives(now);
}

void SharedFlowWindow::asked_again() {
  const core::Lock lock(mutex_);
  lengths_.asked_again();
}

void SharedFlowWindow::refused(Time now) {
  const core::Lock lock(mutex_);
  window_.refused(now);
  note_answers(now);
}

void SharedFlowWindow::move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host) {
  const core::Lock lock(mutex_);
  window_.move(secret, std::move(host));
  lengths_ = {};
  answers_.store(!asks_, std::memory_order_relaxed);
}

}  // namespace sft::udp
