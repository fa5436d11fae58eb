#include "udp_transport/flow/flow_window.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
constexpr std::size_t receive_buffer_bytes_default = 212'992;  // Linux, where nothing was set
constexpr std::chrono::seconds shortest_valid_for{10};
/// While a receiver is kept from running, its buffer has to hold what comes.
constexpr std::uint64_t receiver_pauses_per_s = 500;
/// The receiver counts as silent after so many marks without an answer that are not too far from each other.
constexpr int marks_of_silence = 3;
constexpr std::chrono::seconds longest_pause_between_marks{3};

std::int64_t ns_of(FlowWindow::Time time) { return time.time_since_epoch().count(); }
}  // namespace

FlowWindow::FlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret,
                       std::shared_ptr<UnprovenBudget> host)
    : flow_(flow),
      limits_(limits),
      secret_(secret),
      host_(std::move(host)),
      share_(0),
      sustainable_(limits.first_bytes) {
  announce(0);
}

/// Less than any system grants unasked is not believed: it would never get a sample. The rest may be others'.
void FlowWindow::announce(std::size_t receive_buffer_bytes) {
  if (!heard_) share_ = usable_bytes(std::max(receive_buffer_bytes, receive_buffer_bytes_default)) / 4;
}

/// At which what was sent is believed to pass without a report: not while one is waited for.
double FlowWindow::believed_rate() const {
  if (!limits_.asks)
    return static_cast<double>(std::min(limits_.unheard_bytes_per_s, share_ * receiver_pauses_per_s));
  if (!heard_ || answer_is_due()) return 0;
  return expansion_ * static_cast<double>(limits_.unasked_bytes_per_s);
}

void FlowWindow::pass_time(Time now) {
  if (now - passed_at_ < std::chrono::microseconds(1)) return;
  const std::chrono::duration<double> since = now - std::exchange(passed_at_, now);
  const double bytes = std::min(since.count() * believed_rate(), 1e15);
  passed_ = std::min(sent_, passed_ + static_cast<std::uint64_t>(bytes));
}

/// Several marks, since one may get lost, and a pause in what is sent is no silence of the receiver.
bool FlowWindow::is_mute(Time now) const {
  if (!asked_since_) return false;
  return refused_ || (asked_ >= marks_of_silence && now - *asked_since_ >= limits_.silence);
}

std::size_t FlowWindow::unproven_datagrams_left(Time now) const {
  const std::size_t left =
      limits_.unproven_datagrams - std::min(limits_.unproven_datagrams, unproven_datagrams_);
  return left == 0 || host_ == nullptr ? left : std::min(left, host_->left(now));
}

/// Large samples wait for the report, which opens the whole window a round trip later.
std::size_t FlowWindow::room_before_report(Size size, Time now) const {
  if (size == Size::large || is_mute(now) || unproven_bytes_ >= limits_.unproven_bytes) return 0;
  return std::min(limits_.unproven_bytes - unproven_bytes_,
                  unproven_datagrams_left(now) * datagram_bytes_min);
}

void FlowWindow::note_unproven(std::size_t bytes, std::size_t datagrams, Time now) {
  if (heard_ || !limits_.asks) return;
  unproven_bytes_ += bytes;
  unproven_datagrams_ += datagrams;
  if (host_ != nullptr) host_->spend(datagrams, now);
}

std::size_t FlowWindow::room(Size size, Time now) {
  pass_time(now);
  if (limits_.asks && !heard_) {
    const std::size_t room = room_before_report(size, now);
    waiting_ = waiting_ || room == 0;
    return room;
  }
  const std::size_t limit = size == Size::large ? window() - window() / 4 : share_;
  const std::size_t taken = under_way();
  const bool is_silent = silent(now);
  if (taken == 0 && !is_silent) return std::max<std::size_t>(limit, 1);
  if (taken < limit && !is_silent) return limit - taken;
  waiting_ = true;
  if (sustainable_ <= share_) full_at_ = sent_;
  return 0;
}

bool FlowWindow::takes_control(Time now) {
  if (answers(now)) return true;
  if (heard_ || is_mute(now) || unproven_datagrams_left(now) == 0) return false;
  note_unproven(0, 1, now);
  return true;
}

std::size_t FlowWindow::batch_bytes() const { return std::max<std::size_t>(window() / 6, 1); }

void FlowWindow::sent(std::size_t bytes, std::size_t datagrams, Time now, bool aside) {
  pass_time(now);
  const std::size_t taken = socket_bytes(bytes, datagrams);
  sent_ += taken;
  note_unproven(bytes, datagrams, now);
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

/// A receiver that does not answer is asked more and more seldom. On a short way the pause stays short as
/// long as the receiver does not count as silent: there a missing answer was lost, and a longer pause would
/// only make the window stand still for longer.
FlowWindow::Time::duration FlowWindow::retry_pause() const {
  if (is_mute(marked_at_)) {
    const Time::duration longest = heard_ ? limits_.mark_silent_longest : limits_.mark_unproven_longest;
    return std::clamp<Time::duration>((marked_at_ - *asked_since_) / 8, limits_.mark_silent, longest);
  }
  const auto first = std::clamp<Time::duration>(2 * latest_, limits_.mark_again, limits_.mark_again_unheard);
  const auto after = [first](int marks) { return first * (1 << std::min(marks, 6)); };
  const auto longest =
      std::clamp<Time::duration>(8 * std::min<Time::duration>(shortest_, limits_.mark_again_longest),
                                 limits_.mark_again_unheard, limits_.mark_again_longest);
  return heard_ ? std::min(after(unanswered_), longest)
                : std::min<Time::duration>(after(asked_ - 1), limits_.mark_silent);
}

bool FlowWindow::mark_is_due(Time now) const {
  if (!limits_.asks) return false;
  const bool is_news = sent_ > marked_;
  if (!heard_) return (waiting_ || is_news) && (!asked_since_ || now >= next_retry());
  if (silent(now)) return waiting_ && now >= next_retry();
  if (sent_ - std::max(marked_, passed_) > mark_spacing()) return true;
  const auto unasked = acks_come_ ? limits_.mark_anew_behind_acks : limits_.mark_anew;
  const Time::duration anew = asked_since_ ? limits_.mark_silent : unasked;
  if (is_news && now - std::max(heard_at_, marked_at_) >= anew) return true;
  return waiting_ && under_way() > 0 && now >= next_retry();
}

/// A receiver that has never reported has some marks of its own, and shares further ones with its host.
bool FlowWindow::takes_mark(Time now) {
  if (heard_ || unproven_marks_++ < limits_.unproven_marks) return true;
  return host_ == nullptr || host_->takes_mark(now);
}

std::optional<FlowMark> FlowWindow::mark(Time now) {
  if (!mark_is_due(now)) return {};
  if (!takes_mark(now)) {
    marked_at_ = std::max(marked_at_, now);  // as if it were sent: in its turn the next one may go
    return {};
  }
  unanswered_ = marked_ == sent_ ? unanswered_ + 1 : 0;
  if (first_marked_at_ == Time{}) first_marked_at_ = now;
  if (!asked_since_ || (!is_mute(now) && now - marked_at_ > longest_pause_between_marks)) {
    asked_since_ = now;
    asked_ = 0;
  }
  ++asked_;
  marked_ = sent_;
  marked_at_ = std::max(marked_at_, now);  // of several threads one may have looked at the clock before
  return FlowMark{
      .flow = flow_, .position = sent_, .datagrams = datagrams_, .sent_at_ns = hidden(ns_of(now))};
}

bool FlowWindow::answers_a_mark(const FlowReport& report) const {
  if (report.flow != flow_ || report.position > sent_ || report.position < reported_) return false;
  const std::int64_t sent_at_ns = hidden(report.sent_at_ns);
  return first_marked_at_ != Time{} && sent_at_ns >= ns_of(first_marked_at_) &&
         sent_at_ns <= ns_of(marked_at_);
}

bool FlowWindow::hear(const FlowReport& report, Time now) {
  if (!answers_a_mark(report)) return false;
  pass_time(now);
  const bool was_awaited = !answers(now);
  learn(report, now);
  if (host_ != nullptr) {
    if (!heard_) host_->give_back(unproven_datagrams_);
    host_->answered(now);
  }
  heard_ = true;
  note_life(now);
  unanswered_ = 0;
  share_ = std::max<std::size_t>(report.window_bytes, 1);
  reported_ = report.position;
  passed_ = std::max(passed_, report.position);
  const std::size_t limit = window() - window() / 4;
  return waiting_ && (was_awaited || under_way() <= limit / 2) && std::exchange(waiting_, false);
}

void FlowWindow::note_life(Time now) {
  heard_at_ = now;
  asked_since_.reset();
  asked_ = 0;
  refused_ = false;
}

void FlowWindow::lives(Time now) {
  acks_come_ = true;
  if (heard_ && !silent(now)) note_life(now);
}

void FlowWindow::refused(Time now) {
  if (!limits_.asks || (heard_ && now - heard_at_ < limits_.mark_silent)) return;
  refused_ = true;
  if (!asked_since_) asked_since_ = now;
}

/// Datagrams that are under way no longer arrive, and everything that was learnt was about another way.
void FlowWindow::move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host) {
  secret_ = secret;
  host_ = std::move(host);
  heard_ = false;
  unproven_bytes_ = unproven_datagrams_ = unproven_marks_ = 0;
  passed_ = marked_ = reported_ = sent_;
  first_marked_at_ = {};
  asked_since_.reset();
  asked_ = 0;
  refused_ = acks_come_ = false;
  sustainable_ = limits_.first_bytes;
  latest_ = limits_.mark_again_unheard;
  shortest_ = Time::duration::max();
  full_at_ = turned_at_ = 0;
}

FlowWindow::Time FlowWindow::next_ready(Time now) const {
  if (!answers(now) || (limits_.asks && answer_is_due())) return std::max(now, next_retry());
  const double seconds = static_cast<double>(window() / 4) / believed_rate();
  return now + std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

/// Returns true if many of the datagrams since the previous report were lost.
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
  const Time::duration there_and_back = now - Time(std::chrono::nanoseconds(hidden(report.sent_at_ns)));
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
