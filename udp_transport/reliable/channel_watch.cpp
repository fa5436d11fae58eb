#include "udp_transport/reliable/channel_watch.h"

#include <algorithm>

namespace sft::udp {

ChannelWatch::Verdict ChannelWatch::judge(const Claim& claim, Time now) {
  if (!present_) {
    heard_at_ = now;
    return Verdict::turn;
  }
  if (claim.channel == *present_) {
    heard_at_ = now;
    claims_ = 0;
    return Verdict::present;
  }
  const auto known = std::ranges::find(former_, claim.channel, &Former::channel);
  const bool is_former = known != former_.end();
  const bool is_behind = is_former && claim.last < known->next;
  const bool is_alike = is_like_present(claim.channel);
  const bool follows_on = !is_former && !precedes(claim.channel) && !is_alike;
  const bool begins = follows_on && claim.first <= beginning_max;
  if (claim.channel != doubted_) claims_ = 0;
  if (claims_ == 0) {
    doubted_since_ = now;
    ordinals_claimed_ = 0;
  }
  if (claims_ == 0 || claim.last != last_claimed_) ++ordinals_claimed_;
  last_claimed_ = claim.last;
  doubted_ = claim.channel;
  if (!claim.same_datagram) ++claims_;
  const bool present_is_silent = now - doubted_since_ >= present_doubted_after;
  const std::uint32_t enough = is_behind ? behind_in_a_row : is_alike ? alike_in_a_row : 2;
  const bool confirmed = claims_ >= enough && (follows_on || present_is_silent);
  const bool goes_on = !is_behind && ordinals_claimed_ >= in_a_row;
  if (!begins && !confirmed && !goes_on) return Verdict::ignore;
  if (is_behind) known->next = claim.first;  // it had been followed too far
  heard_at_ = now;
  return Verdict::turn;
}

std::uint64_t ChannelWatch::turn(std::uint32_t channel, std::uint64_t next) {
  std::uint64_t begin = 1;
  if (const Former* const known = former(channel)) begin = known->next;
  std::erase_if(former_, [&](const Former& one) { return one.channel == channel; });
  if (present_) {
    if (former_.size() == former_max) former_.erase(former_.begin());
    former_.push_back({*present_, next});
  }
  present_ = channel;
  claims_ = 0;
  return begin;
}

std::optional<std::uint32_t> ChannelWatch::widen(std::uint32_t low, std::uint32_t end) const {
  if (!present_ || *present_ % end == low) return present_;
  const auto known = std::find_if(former_.rbegin(), former_.rend(),
                                  [&](const Former& one) { return one.channel % end == low; });
  if (known != former_.rend()) return known->channel;
  const std::uint32_t least = *present_ - end / 2;
  return least + (low - least) % end;
}

const ChannelWatch::Former* ChannelWatch::former(std::uint32_t channel) const {
  const auto known = std::ranges::find(former_, channel, &Former::channel);
  return known == former_.end() ? nullptr : &*known;
}

}  // namespace sft::udp
