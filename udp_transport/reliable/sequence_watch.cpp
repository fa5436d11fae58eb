#include "udp_transport/reliable/sequence_watch.h"

#include <algorithm>
#include <utility>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {

std::uint64_t distance(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : b - a; }

/// Returns how far ahead a writer can be that was not heard for that time.
std::uint64_t reach_after(SequenceWatch::Time::duration silence) {
  using Seconds = std::chrono::duration<double>;
  constexpr double longest_s = 1e6;
  const double seconds = std::clamp(Seconds(silence).count(), 0.0, longest_s);
  return SequenceWatch::reach +
         static_cast<std::uint64_t>(seconds * static_cast<double>(SequenceWatch::published_per_s_max));
}

}  // namespace

bool SequenceWatch::Row::add(std::uint64_t sequence, Time now) {
  if (datagrams++ == 0) since = now;
  return std::exchange(last, sequence) < sequence && datagrams > 1;
}

bool SequenceWatch::judge(const Claim& claim, Time now) {
  const std::uint64_t sequence = claim.sequence;
  const bool is_ahead = sequence > newest();
  if (newest() == 0 || (is_ahead && sequence - newest() <= reach_after(now - advanced_at_))) {
    advance(claim, now);
    return true;
  }
  if (is_ahead || newest() - sequence > reach_back) return judge_far(claim, now);
  judge_late(claim, now);
  return true;
}

/// Wrong numbers are seldom near each other, and true ones come between them while the writer is heard.
bool SequenceWatch::judge_far(const Claim& claim, Time now) {
  if (std::exchange(last_doubtful_, claim.datagram) == claim.datagram) return false;
  if (distance(claim.sequence, far_.last) > reach) far_ = {};
  if (!far_.add(claim.sequence, now) || !far_.lasts(now)) return false;
  begin_anew(claim, now, claim.sequence < newest());
  return true;
}

/// The newest sample itself, in another variant, is not late.
void SequenceWatch::judge_late(const Claim& claim, Time now) {
  far_ = {};
  if (claim.sequence == newest()) return;
  if (std::exchange(last_doubtful_, claim.datagram) == claim.datagram) return;
  const bool was_published_later = is_younger(claim);
  const bool is_repair = claim.place != 0 && claim.place < newest_.place && !was_published_later;
  const bool ascends = late_.add(claim.sequence, now);
  const bool are_many = ascends && late_.datagrams >= late_in_a_row && late_.lasts(now);
  const bool counts = was_published_later || (claim.stamp_ns > newest_.stamp_ns && !is_repair);
  const bool goes_on = counts && later_.add(claim.sequence, now) && later_.lasts(now);
  if (goes_on || are_many) begin_anew(claim, now, goes_on);
}

void SequenceWatch::advance(const Claim& claim, Time now) {
  if (claim.datagram != newest_.datagram) count_step(claim, now);
  newest_ = claim;
  advanced_at_ = now;
  far_ = late_ = later_ = {};
}

/// The samples of one packed datagram are one step: its stamp would else be taken for true at once.
void SequenceWatch::count_step(const Claim& claim, Time now) {
  const bool is_small = claim.sequence > newest() && claim.sequence - newest() <= small_step;
  small_steps_ = is_small ? small_steps_ + 1 : 0;
  if (small_steps_ < steady_steps) return;
  steady_ = claim.sequence;
  steady_stamp_ns_ = claim.stamp_ns;
  steady_at_ = now;
}

void SequenceWatch::begin_anew(const Claim& claim, Time now, bool newest_was_wrong) {
  advance(claim, now);
  newest_was_wrong_ = newest_was_wrong;
  ++numbering_;
}

std::uint64_t SequenceWatch::widen(std::uint32_t low) const {
  const std::uint64_t goes_on = widen_sequence(steady_, low);
  return steady_ != 0 && distance(goes_on, steady_) <= reach ? goes_on : widen_sequence(newest(), low);
}

/// True if by its stamp the sample was published after the newest one came, whatever the stamp of that one
/// says: it may be as wrong as its sequence.
bool SequenceWatch::is_younger(const Claim& claim) const {
  if (steady_ == 0) return false;
  const auto since_steady = static_cast<std::int64_t>(static_cast<std::uint64_t>(claim.stamp_ns) -
                                                      static_cast<std::uint64_t>(steady_stamp_ns_));
  return std::chrono::nanoseconds(since_steady) > advanced_at_ - steady_at_;
}

}  // namespace sft::udp
