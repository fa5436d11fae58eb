#include "tests/simulation/udp/loss_account.h"

#include <algorithm>
#include <utility>

namespace sft::simulation {

void LossAccount::sent(std::uint32_t channel, std::uint64_t ordinal, const Variant& sample) {
  channels_[channel].sent.emplace(ordinal, sample);
}

void LossAccount::dropped(std::uint32_t channel, std::uint64_t ordinal) {
  dropped_.insert(channels_[channel].sent.at(ordinal).sequence);
}

void LossAccount::process_started() {
  came_.clear();
  refused_.clear();
  for (auto& [number, channel] : channels_) channel = {.sent = std::move(channel.sent)};
}

void LossAccount::heard(const std::optional<udp::ArrivalWindow::Mark>& before,
                        const std::optional<udp::ArrivalWindow::Mark>& mark,
                        const std::optional<udp::Heartbeat>& heartbeat) {
  if (!mark) return;
  Channel& channel = channels_[mark->channel];
  if (before && before->channel != mark->channel) {
    Channel& last = channels_[before->channel];
    last.gone_before = before->end;
    channel.base = last.base + before->end - 1;
  }
  const bool is_of_channel = heartbeat && heartbeat->channel == mark->channel;
  // A heartbeat makes the channel known even before its first sample. After that, a missing sample of the
  // channel counts as lost.
  if (!channel.known_from && (is_of_channel || mark->end > 1))
    channel.known_from = heartbeat ? heartbeat->first : 1;
  if (is_of_channel) channel.gone_before = std::max(channel.gone_before, heartbeat->first);
}

std::uint64_t LossAccount::lost(std::uint32_t channel, udp::ArrivalWindow::Place next) const {
  std::uint64_t sum = 0;
  for (const auto& [number, one] : channels_) {
    const std::uint64_t handed_over = number == channel ? std::max(next, one.base) - one.base : 0;
    sum += missing(one, std::max(handed_over, one.gone_before));
  }
  return sum;
}

std::uint64_t LossAccount::lost_in_the_end(std::uint32_t channel) {
  const Channel& former = channels_[channel - 1];
  return missing(former, former.gone_before) + missing(channels_[channel], UINT64_MAX);
}

/// Returns the number of missing samples before the ordinal `end`. Counts only samples that the process knows
/// of.
std::uint64_t LossAccount::missing(const Channel& channel, std::uint64_t end) const {
  if (!channel.known_from) return 0;
  const auto first = channel.sent.lower_bound(*channel.known_from);
  const auto behind = std::max(end, *channel.known_from);
  return static_cast<std::uint64_t>(
      std::count_if(first, channel.sent.lower_bound(behind), [this](const auto& sample) {
        return !came_.contains(sample.second) && !refused_.contains(sample.second);
      }));
}

}  // namespace sft::simulation
