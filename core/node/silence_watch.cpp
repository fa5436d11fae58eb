#include "core/node/silence_watch.h"

namespace sft::core {

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
