#include "udp_transport/reliable/sequence_monitor.h"

#include <algorithm>
#include <utility>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {

std::uint64_t distance(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : b - a; }

/// Returns the maximum number of samples that a writer can have published during that silence, plus
/// SequenceMonitor::reach.
std::uint64_t reach_after(SequenceMonitor::Time::duration silence) {
  using Seconds = std::chrono::duration<double>;
  constexpr double longest_s = 1e6;
  const double seconds = std::clamp(Seconds(silence).count(), 0.0, longest_s);
  return SequenceMonitor::reach +
         static_cast<std::uint64_t>(seconds * static_cast<double>(SequenceMonitor::published_per_s_max));
}

}  // namespace

bool SequenceMonitor::Row::add(std::uint64_t sequence, Time now) {
  if (datagrams++ == 0) since = now;
  return std::exchange(last, sequence) < sequence && datagrams > 1;
}

bool SequenceMonitor::evaluate(const Observed& observed, Time now) {
  const std::uint64_t sequence = observed.sequence;
  const bool is_ahead = sequence > newest();
  if (newest() == 0 || (is_ahead && sequence - newest() <= reach_after(now - advanced_at_))) {
    advance(observed, now);
    return true;
  }
  if (is_ahead || newest() - sequence > reach_back) return evaluate_far(observed, now);
  evaluate_late(observed, now);
  return true;
}

/// Returns true if a sequence far from the newest one is believed. Wrong sequences are rarely near each
/// other, and while the writer sends, correct sequences come between them.
bool SequenceMonitor::evaluate_far(const Observed& observed, Time now) {
  if (std::exchange(last_unconfirmed_, observed.datagram) == observed.datagram) return false;
  if (distance(observed.sequence, far_.last) > reach) far_ = {};
  if (!far_.add(observed.sequence, now) || !far_.lasts(now)) return false;
  begin_anew(observed, now, observed.sequence < newest());
  return true;
}

/// Handles a late sample. The newest sample itself, in another variant, is not late.
void SequenceMonitor::evaluate_late(const Observed& observed, Time now) {
  far_ = {};
  if (observed.sequence == newest()) return;
  if (std::exchange(last_unconfirmed_, observed.datagram) == observed.datagram) return;
  const bool was_published_later = is_younger(observed);
  const bool is_repair = observed.place != 0 && observed.place < newest_.place && !was_published_later;
  const bool ascends = late_.add(observed.sequence, now);
  const bool are_many = ascends && late_.datagrams >= late_in_a_row && late_.lasts(now);
  const bool counts = was_published_later || (observed.stamp_ns > newest_.stamp_ns && !is_repair);
  const bool goes_on = counts && later_.add(observed.sequence, now) && later_.lasts(now);
  if (goes_on || are_many) begin_anew(observed, now, goes_on);
}

void SequenceMonitor::advance(const Observed& observed, Time now) {
  if (observed.datagram != newest_.datagram) count_step(observed, now);
  newest_ = observed;
  advanced_at_ = now;
  far_ = late_ = later_ = {};
}

/// Counts small steps of the sequence. The samples of one packed datagram count as one step. Otherwise the
/// stamp of a single datagram would be trusted at once.
void SequenceMonitor::count_step(const Observed& observed, Time now) {
  const bool is_small = observed.sequence > newest() && observed.sequence - newest() <= small_step;
  small_steps_ = is_small ? small_steps_ + 1 : 0;
  if (small_steps_ < steady_steps) return;
  steady_ = observed.sequence;
  steady_stamp_ns_ = observed.stamp_ns;
  steady_at_ = now;
}

void SequenceMonitor::begin_anew(const Observed& observed, Time now, bool newest_was_wrong) {
  advance(observed, now);
  newest_was_wrong_ = newest_was_wrong;
  ++numbering_;
}

std::uint64_t SequenceMonitor::widen(std::uint32_t low) const {
  const std::uint64_t goes_on = widen_sequence(steady_, low);
  return steady_ != 0 && distance(goes_on, steady_) <= reach ? goes_on : widen_sequence(newest(), low);
}

/// Returns true if the stamp of the sample shows that it was published after the newest sample came. The
/// stamp of the newest sample is not used, since it may be as wrong as its sequence.
bool SequenceMonitor::is_younger(const Observed& observed) const {
  if (steady_ == 0) return false;
  const auto since_steady = static_cast<std::int64_t>(static_cast<std::uint64_t>(observed.stamp_ns) -
                                                      static_cast<std::uint64_t>(steady_stamp_ns_));
  return std::chrono::nanoseconds(since_steady) > advanced_at_ - steady_at_;
}

}  // namespace sft::udp
