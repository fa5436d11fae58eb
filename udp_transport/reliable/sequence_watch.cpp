#include "udp_transport/reliable/sequence_watch.h"

#include <algorithm>

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

bool SequenceWatch::judge(const Claim& claim, Time now) {
  const std::uint64_t sequence = claim.sequence;
  if (newest() == 0) {
    advance(claim, now);
    return true;
  }
  if (sequence > newest()) {
    if (sequence - newest() <= reach_after(now - advanced_at_)) {
      advance(claim, now);
      return true;
    }
  } else if (newest() - sequence <= reach_back) {
    const bool is_repair = claim.place != 0 && claim.place < newest_.place && !is_younger(claim);
    const bool begins_anew = is_repair ? note_repair(claim, now) : note_late(claim, now);
    if (begins_anew) begin_anew(claim, now);
    newest_was_wrong_ = begins_anew && !is_repair;
    return true;
  }
  if (!confirmed(claim, now)) return false;
  newest_was_wrong_ = sequence < newest();
  begin_anew(claim, now);
  return true;
}

void SequenceWatch::advance(const Claim& claim, Time now) {
  if (claim.datagram != newest_.datagram) count_step(claim, now);
  newest_ = claim;
  advanced_at_ = now;
  doubted_ = 0;
  late_.end();
  later_.end();
  repairs_.end();
}

/// The samples of one packed datagram are one step: its stamp would else be taken for true at once.
void SequenceWatch::count_step(const Claim& claim, Time now) {
  const bool is_small = claim.sequence > newest() && claim.sequence - newest() <= small_step;
  small_steps_ = is_small ? small_steps_ + 1 : 0;
  if (small_steps_ < steady_steps) return;
  steady_ = claim.sequence;
  steady_stamp_ns_ = claim.stamp_ns;
  steady_at_ = now;
  ++advances_;
}

void SequenceWatch::begin_anew(const Claim& claim, Time now) {
  if (advances_ > 0 && advances_ >= before_advances_) {
    before_ = steady_;
    before_advances_ = std::min(advances_, advances_counted_max);
  }
  advances_ = distance(claim.sequence, before_) <= reach ? before_advances_ : 0;
  advance(claim, now);
  ++numbering_;
}

std::uint64_t SequenceWatch::widen(std::uint32_t low) const {
  const std::uint64_t goes_on = widen_sequence(before_, low);
  return before_ != 0 && distance(goes_on, before_) <= reach ? goes_on : widen_sequence(newest(), low);
}

bool SequenceWatch::confirmed(const Claim& claim, Time now) {
  const std::uint64_t sequence = claim.sequence;
  const bool is_other = sequence != doubted_ || now - doubted_at_ >= repeated_after;
  if (doubted_ != 0 && claim.datagram != doubted_datagram_ && distance(sequence, doubted_) <= reach &&
      is_other)
    return true;
  const bool same_again = doubted_ == sequence;
  doubted_ = sequence;
  doubted_datagram_ = claim.datagram;
  if (!same_again) doubted_at_ = now;
  return false;
}

/// True if the newest sequence must have been wrong. The newest one itself, in another variant, is not late.
bool SequenceWatch::note_late(const Claim& claim, Time now) {
  const std::uint64_t sequence = claim.sequence;
  if (sequence == newest() || claim.datagram == last_late_datagram_) return false;
  last_late_datagram_ = claim.datagram;
  late_.add(sequence, now);
  const bool is_far = newest() - sequence > reach;
  const bool are_enough = late_.count() >= late_in_a_row || (late_.count() >= 2 && is_far);
  return note_later(claim, now) || (are_enough && late_.lasts(now) >= newest_doubted_after);
}

/// Counts those late ones that were published after the newest one, by their stamps. Their order means
/// nothing: repairs of samples before them may come between them. But the numbering goes on with a new one.
bool SequenceWatch::note_later(const Claim& claim, Time now) {
  if (claim.stamp_ns <= newest_.stamp_ns && !is_younger(claim)) return false;
  const bool ascends = later_.add_in_any_order(claim.sequence, now);
  return ascends && later_.lasts(now) >= newest_doubted_after;
}

/// By its stamp it was published after the newest one came, whatever the stamp of that one says.
bool SequenceWatch::is_younger(const Claim& claim) const {
  if (steady_ == 0) return false;
  const auto since_steady = static_cast<std::int64_t>(static_cast<std::uint64_t>(claim.stamp_ns) -
                                                      static_cast<std::uint64_t>(steady_stamp_ns_));
  return std::chrono::nanoseconds(since_steady) > advanced_at_ - steady_at_;
}

/// The place of the newest one can be wrong as well: then what looks like repairs goes on and on, and nothing
/// else comes.
bool SequenceWatch::note_repair(const Claim& claim, Time now) {
  if (claim.datagram == last_late_datagram_) return false;
  last_late_datagram_ = claim.datagram;
  repairs_.add(claim.sequence, now);
  return repairs_.count() >= late_in_a_row && repairs_.lasts(now) >= newest_doubted_after;
}

}  // namespace sft::udp
