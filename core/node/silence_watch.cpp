#include "core/node/silence_watch.h"

#include <algorithm>

#include "core/discovery/leases.h"

namespace sft::core {

void SilenceWatch::heard(NodeId node, std::chrono::milliseconds lease, Time now) {
  const bool is_new = !watched_.contains(node) && !lost_at_.contains(node);
  const auto at = now + lease + (is_new ? renewal_takes : std::chrono::seconds(0));
  Time& lost_at = lost_at_[node];
  lost_at = std::max(lost_at, at);
}

void SilenceWatch::lives(NodeId node) {
  lost_at_.erase(node);
  watched_.insert(node);
}

bool SilenceWatch::is_lost(NodeId node, Time now) {
  watched_.erase(node);
  const auto lost_at = lost_at_.find(node);
  return lost_at == lost_at_.end() || now >= lost_at->second;
}

std::vector<NodeId> SilenceWatch::take_lost(Time now) {
  std::vector<NodeId> lost;
  std::erase_if(lost_at_, [&](const auto& item) {
    if (now < item.second) return false;
    if (!watched_.contains(item.first)) lost.push_back(item.first);
    return true;
  });
  return lost;
}

}  // namespace sft::core
