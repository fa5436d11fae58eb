#include "udp_transport/reliable/channel_monitor.h"

#include <algorithm>

namespace sft::udp {

ChannelMonitor::Verdict ChannelMonitor::evaluate(const Observed& observed, Time now) {
  if (!present_) {
    heard_at_ = now;
    return Verdict::turn;
  }
  if (observed.channel == *present_) {
    heard_at_ = now;
    observations_ = 0;
    return Verdict::present;
  }
  const auto known = std::ranges::find(former_, observed.channel, &Former::channel);
  const bool is_former = known != former_.end();
  const bool is_behind = is_former && observed.last < known->next;
  const bool is_alike = is_like_present(observed.channel);
  const bool follows_on = !is_former && !precedes(observed.channel) && !is_alike;
  const bool begins = follows_on && observed.first <= beginning_max;
  if (observed.channel != unconfirmed_) observations_ = 0;
  if (observations_ == 0) {
    unconfirmed_since_ = now;
    ordinals_observed_ = 0;
  }
  if (observations_ == 0 || observed.last != last_observed_) ++ordinals_observed_;
  last_observed_ = observed.last;
  unconfirmed_ = observed.channel;
  if (!observed.same_datagram) ++observations_;
  const bool present_is_silent = now - unconfirmed_since_ >= present_unconfirmed_after;
  const std::uint32_t enough = is_behind ? behind_in_a_row : is_alike ? alike_in_a_row : 2;
  const bool confirmed = observations_ >= enough && (follows_on || present_is_silent);
  const bool goes_on = !is_behind && ordinals_observed_ >= in_a_row;
  if (!begins && !confirmed && !goes_on) return Verdict::ignore;
  // The next ordinal that was recorded when the channel was left was too high.
  if (is_behind) known->next = observed.first;
  heard_at_ = now;
  return Verdict::turn;
}

std::uint64_t ChannelMonitor::turn(std::uint32_t channel, std::uint64_t next) {
  std::uint64_t begin = 1;
  if (const Former* const known = former(channel)) begin = known->next;
  std::erase_if(former_, [&](const Former& one) { return one.channel == channel; });
  if (present_) {
    if (former_.size() == former_max) former_.erase(former_.begin());
    former_.push_back({*present_, next});
  }
  present_ = channel;
  observations_ = 0;
  return begin;
}

std::optional<std::uint32_t> ChannelMonitor::widen(std::uint32_t low, std::uint32_t end) const {
  if (!present_ || *present_ % end == low) return present_;
  const auto known = std::find_if(former_.rbegin(), former_.rend(),
                                  [&](const Former& one) { return one.channel % end == low; });
  if (known != former_.rend()) return known->channel;
  const std::uint32_t least = *present_ - end / 2;
  return least + (low - least) % end;
}

const ChannelMonitor::Former* ChannelMonitor::former(std::uint32_t channel) const {
  const auto known = std::ranges::find(former_, channel, &Former::channel);
  return known == former_.end() ? nullptr : &*known;
}

}  // namespace sft::udp
