#include "udp_transport/flow_window.h"

namespace sft::udp {

namespace {
constexpr std::size_t receive_buffer_bytes_default = 212'992;  // Linux, where nothing was set
constexpr std::chrono::seconds shortest_valid_for{10};
/// While a receiver is kept from running, its buffer has to hold what comes.
constexpr std::uint64_t receiver_pauses_per_s = 500;
}  // namespace

FlowWindow::FlowWindow(std::uint32_t flow, const FlowLimits& limits)
    : flow_(flow), limits_(limits), share_(0), sustainable_(limits.first_bytes) {
  announce(0);
}

/// Less than any system grants unasked is not believed: it would never get a sample. The rest may be others'.
void FlowWindow::announce(std::size_t receive_buffer_bytes) {
  if (!heard_) share_ = usable_bytes(std::max(receive_buffer_bytes, receive_buffer_bytes_default)) / 4;
}

/// At which what was sent is believed to pass without a report: not while one is waited for.
double FlowWindow::believed_rate(Time now) const {
  if (answer_is_due() && (heard_ || now < report_expected_until())) return 0;
  if (heard_) return expansion_ * static_cast<double>(limits_.unasked_bytes_per_s);
  return static_cast<double>(std::min(limits_.unheard_bytes_per_s, share_ * receiver_pauses_per_s));
}

void FlowWindow::pass_time(Time now) {
  if (now - passed_at_ < std::chrono::microseconds(1)) return;
  const std::chrono::duration<double> since = now - std::exchange(passed_at_, now);
  const auto passes = [&](std::uint64_t& position, double bytes_per_s) {
    const double bytes = std::min(since.count() * bytes_per_s, 1e15);
    position = std::min(sent_, position + static_cast<std::uint64_t>(bytes));
  };
  passes(passed_, believed_rate(now));
  if (!heard_) passes(surely_passed_, expansion_ * static_cast<double>(limits_.unasked_bytes_per_s));
  if (under_way() == 0) heard_at_ = now;
  if (now - heard_at_ > limits_.silence) {  // its reports get lost, or it is kept from running
    passed_ = sent_;
    heard_at_ = now;
  }
}

std::size_t FlowWindow::room(Size size, Time now) {
  pass_time(now);
  const std::size_t limit = size == Size::large ? window() - window() / 4 : share_;
  const std::size_t taken = under_way();
  if (taken == 0) return std::max<std::size_t>(limit, 1);
  if (taken < limit) return limit - taken;
  waiting_ = true;
  if (sustainable_ <= share_) full_at_ = sent_;
  return 0;
}

std::size_t FlowWindow::batch_bytes() const { return std::max<std::size_t>(window() / 6, 1); }

void FlowWindow::sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside) {
  pass_time(now);
  const std::size_t taken = socket_bytes(bytes, datagrams);
  sent_ += taken;
  expansion_ +=
      (static_cast<double>(taken) / static_cast<double>(std::max<std::size_t>(bytes, 1)) - expansion_) / 8;
  if (!aside) datagrams_ += static_cast<std::uint32_t>(datagrams);
}

/// Several in a window, of which a small one is soon full; but none for what is seldom and small.
std::size_t FlowWindow::mark_spacing() const {
  const std::size_t seldom = std::min(window() / 2, limits_.mark_spacing_min);
  const std::size_t part = window() / (window() < limits_.first_bytes ? 4 : 2);
  return std::max(seldom, std::min(part, limits_.mark_spacing_max));
}

FlowWindow::Time FlowWindow::next_retry() const {
  const auto first = std::clamp<Time::duration>(2 * latest_, limits_.mark_again, limits_.mark_again_unheard);
  return marked_at_ +
         std::min<Time::duration>(first * (1 << std::min(unanswered_, 6)), limits_.mark_again_longest);
}

bool FlowWindow::mark_is_due(Time now) const {
  if (sent_ - std::max(marked_, heard_ ? passed_ : surely_passed_) > mark_spacing()) return true;
  return waiting_ && under_way() > 0 && now >= next_retry();
}

std::optional<FlowMark> FlowWindow::mark(Time now) {
  if (!mark_is_due(now)) return {};
  unanswered_ = marked_ == sent_ ? unanswered_ + 1 : 0;
  if (marked_ == 0) first_marked_at_ = now;
  marked_ = sent_;
  marked_at_ = now;
  return FlowMark{.flow = flow_,
                  .position = sent_,
                  .datagrams = datagrams_,
                  .sent_at_ns = now.time_since_epoch().count()};
}

bool FlowWindow::hear(const FlowReport& report, Time now) {
  if (report.flow != flow_ || report.position > sent_ || report.position < reported_) return false;
  pass_time(now);
  learn(report, now);
  heard_ = true;
  heard_at_ = now;
  unanswered_ = 0;
  share_ = std::max<std::size_t>(report.window_bytes, 1);
  reported_ = report.position;
  passed_ = std::max(passed_, report.position);
  const std::size_t limit = window() - window() / 4;
  return waiting_ && under_way() <= limit / 2 && std::exchange(waiting_, false);
}

FlowWindow::Time FlowWindow::next_ready(Time now) const {
  if (answer_is_due() && (heard_ || now < report_expected_until()))
    return std::max(now, std::min(next_retry(), report_expected_until()));
  const double seconds = static_cast<double>(window() / 4) / believed_rate(now);
  return now + std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

/// Of the datagrams since the report before.
bool FlowWindow::lost_much(const FlowReport& report) const {
  const std::uint32_t sent = report.datagrams - datagrams_at_report_;
  const std::uint32_t came = report.came - came_at_report_;
  return came <= sent && sent - came > sent / 10 + 1;
}

/// Routes change. To see the shortest time again, our own queue has to be short for a moment.
void FlowWindow::note_time_there_and_back(Time::duration time, Time now) {
  if (now - shortest_at_ > shortest_valid_for) {
    if (heard_) sustainable_ = std::max(limits_.least_bytes, sustainable_ / 4);
    shortest_ = Time::duration::max();
    shortest_at_ = now;
  }
  shortest_ = std::min(shortest_, time);
}

/// A longer queue than need be, or much loss: somebody on the way has too much. As long as neither is, more
/// is tried.
void FlowWindow::learn(const FlowReport& report, Time now) {
  const bool lost = heard_ && lost_much(report);
  datagrams_at_report_ = report.datagrams;
  came_at_report_ = report.came;
  if (report.sent_at_ns < 0 || report.sent_at_ns > now.time_since_epoch().count()) return;
  const Time::duration there_and_back = now - Time(std::chrono::nanoseconds(report.sent_at_ns));
  latest_ = there_and_back;
  note_time_there_and_back(there_and_back, now);
  const Time::duration queueing = there_and_back - shortest_;
  if (lost || queueing > limits_.queueing) {
    if (report.position <= turned_at_) return;  // of before it was made smaller
    turned_at_ = sent_;
    sustainable_ = std::max(limits_.least_bytes, sustainable_ / 10 * 7);
  } else if (report.position <= full_at_) {
    const auto came = static_cast<std::size_t>(report.position - reported_);
    const std::size_t more = queueing < limits_.queueing / 4 ? came : came / 8;
    sustainable_ = std::min(sustainable_ + more, std::max(share_, limits_.first_bytes));
  }
}

}  // namespace sft::udp
