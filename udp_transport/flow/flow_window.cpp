#include "udp_transport/flow/flow_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::size_t receive_buffer_bytes_default = 212'992;  // the default of Linux, in bytes
/// The assumed number of times per second that the receiver's threads run. The buffer has to hold the
/// datagrams that come in between, in 1/500 s.
constexpr std::uint64_t receiver_pauses_per_s = 500;

std::int64_t ns_of(FlowWindow::Time time) { return time.time_since_epoch().count(); }
}  // namespace

FlowWindow::FlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret,
                       std::shared_ptr<UnprovenBudget> host)
    : flow_(flow),
      limits_(limits),
      secret_(secret),
      unproven_(limits, std::move(host)),
      receiver_(limits),
      round_trips_(limits.mark_again_unheard),
      congestion_(limits) {
  announce(0);
}

/// Takes the announced size of the receiver's buffer. A size below the usual default of Linux is replaced by
/// that default, since with a very small size the receiver would never get a sample. Until the first report,
/// the share is assumed to be a quarter of the buffer, since other processes may send to the same socket.
void FlowWindow::announce(std::size_t receive_buffer_bytes) {
  if (!receiver_.heard())
    share_ = usable_bytes(std::max(receive_buffer_bytes, receive_buffer_bytes_default)) / 4;
}

/// Returns the bytes per second that are assumed to pass without a report; 0 while a report is due.
double FlowWindow::assumed_rate() const {
  if (!limits_.asks)
    return static_cast<double>(std::min(limits_.unheard_bytes_per_s, share_ * receiver_pauses_per_s));
  if (!receiver_.heard() || answer_is_due()) return 0;
  return expansion_ * static_cast<double>(limits_.unasked_bytes_per_s);
}

void FlowWindow::pass_time(Time now) {
  if (now - passed_at_ < std::chrono::microseconds(1)) return;
  const std::chrono::duration<double> since = now - std::exchange(passed_at_, now);
  const double bytes = std::min(since.count() * assumed_rate(), 1e15);
  passed_ = std::min(sent_, passed_ + static_cast<std::uint64_t>(bytes));
}

void FlowWindow::note_unproven(std::size_t bytes, std::size_t datagrams, Time now) {
  if (limits_.asks && !receiver_.heard()) unproven_.spend(bytes, datagrams, now);
}

/// Large samples wait for the first report, which allows the whole window.
std::size_t FlowWindow::room(Size size, Time now) {
  pass_time(now);
  if (limits_.asks && !receiver_.heard()) {
    const std::size_t room = size == Size::large || is_mute(now) ? 0 : unproven_.bytes_left(now);
    waiting_ = waiting_ || room == 0;
    return room;
  }
  const std::size_t limit = size == Size::large ? window() - window() / 4 : share_;
  const std::size_t taken = under_way();
  const bool is_silent = receiver_.is_silent(now);
  if (taken == 0 && !is_silent) return std::max<std::size_t>(limit, 1);
  if (taken < limit && !is_silent) return limit - taken;
  waiting_ = true;
  return 0;
}

bool FlowWindow::takes_control(Time now) {
  if (answers(now)) return true;
  if (receiver_.heard() || is_mute(now) || unproven_.datagrams_left(now) == 0) return false;
  note_unproven(0, 1, now);
  return true;
}

std::size_t FlowWindow::batch_bytes() const { return std::max<std::size_t>(window() / 6, 1); }

void FlowWindow::sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside) {
  pass_time(now);
  const std::size_t taken = socket_bytes(bytes, datagrams);
  sent_ += taken;
  // The window limits the sending even if no sender waits, because a small window may become full and be
  // reported before the sender calls room() again.
  if (congestion_.bytes() <= share_ && under_way() >= congestion_.bytes() / 2) congestion_.was_full(sent_);
  note_unproven(bytes, datagrams, now);
  expansion_ +=
      (static_cast<double>(taken) / static_cast<double>(std::max<std::size_t>(bytes, 1)) - expansion_) / 8;
  if (!aside) datagrams_ += static_cast<std::uint32_t>(datagrams);
}

/// Returns the number of socket bytes between two flow marks. Several marks are sent for each window of
/// data. The number is not smaller than a minimum, so that rare small samples cause no marks.
std::size_t FlowWindow::mark_spacing() const {
  const std::size_t seldom = std::min(window() / 2, limits_.mark_spacing_min);
  const std::size_t part = window() / (window() < limits_.first_bytes ? 4 : 2);
  return std::max(seldom, std::min(part, limits_.mark_spacing_max));
}

bool FlowWindow::mark_is_due(Time now, bool is_uncertain) const {
  if (!limits_.asks) return false;
  const bool is_news = sent_ > marked_;
  const auto may_retry = [&] { return now >= receiver_.next_retry(round_trips_); };
  if (!receiver_.heard()) return (waiting_ || is_news) && (!receiver_.is_asked() || may_retry());
  if (receiver_.is_silent(now)) return waiting_ && may_retry();
  if (sent_ - std::max(marked_, passed_) > mark_spacing()) return true;
  if (is_news && receiver_.has_to_ask_anew(now, is_uncertain)) return true;
  return waiting_ && under_way() > 0 && may_retry();
}

std::optional<FlowMark> FlowWindow::mark(Time now, bool is_uncertain) {
  if (!mark_is_due(now, is_uncertain)) return {};
  if (!receiver_.heard() && !unproven_.takes_mark(now)) {
    receiver_.put_off(now);
    return {};
  }
  receiver_.ask(marked_ == sent_, now);
  rate_.mark(now);
  marked_ = sent_;
  return FlowMark{
      .flow = flow_, .position = sent_, .datagrams = datagrams_, .sent_at_ns = hidden(ns_of(now))};
}

bool FlowWindow::answers_a_mark(const FlowReport& report) const {
  if (report.flow != flow_ || report.position > sent_ || report.position < reported_) return false;
  return receiver_.may_have_asked_at(marked_at(report));
}

bool FlowWindow::hear(const FlowReport& report, Time now) {
  if (!answers_a_mark(report)) return false;
  pass_time(now);
  const bool was_awaited = !answers(now);
  learn(report, now);
  if (!receiver_.heard()) unproven_.proven();
  unproven_.answered(now);
  receiver_.reported(now);
  share_ = std::max<std::size_t>(report.window_bytes, 1);
  reported_ = report.position;
  passed_ = std::max(passed_, report.position);
  const std::size_t limit = window() - window() / 4;
  return waiting_ && (was_awaited || under_way() <= limit / 2) && std::exchange(waiting_, false);
}

/// Updates the estimates from a report. If the shortest round trip was too old, the window shrinks, so that
/// the queue of our datagrams is short for a moment, and the shortest round trip can be measured again.
void FlowWindow::learn(const FlowReport& report, Time now) {
  const bool begins_anew = round_trips_.note(now - marked_at(report), now);
  rate_.report(report.position, marked_at(report), now);
  if (begins_anew && receiver_.heard()) congestion_.make_queue_short();
  congestion_.hear(report, {.counted = receiver_.heard(),
                            .queueing = round_trips_.queueing(),
                            .reported = reported_,
                            .sent = sent_,
                            .share = share_,
                            .taken = rate_.bytes_within(round_trips_.shortest() + limits_.queueing)});
}

/// Sends to another address from now on. Datagrams under way to the former address no longer count as
/// arriving. All estimates are reset, because the path is different.
void FlowWindow::move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host) {
  secret_ = secret;
  unproven_.begin_anew(std::move(host));
  receiver_.begin_anew();
  round_trips_.forget();
  rate_ = {};
  congestion_.begin_anew();
  passed_ = marked_ = reported_ = sent_;
}

FlowWindow::Time FlowWindow::next_ready(Time now) const {
  if (!answers(now) || (limits_.asks && answer_is_due()))
    return std::max(now, receiver_.next_retry(round_trips_));
  const double seconds = static_cast<double>(window() / 4) / assumed_rate();
  return now + std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

}  // namespace sft::udp
