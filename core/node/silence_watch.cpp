#include "core/node/silence_watch.h"

namespace sft::core {

bool SilenceWatch::is_lost(NodeId node, Time now) const {
  const auto heard = lost_at_.find(node);
  return heard == lost_at_.end() || now >= heard->second;
}

std::vector<NodeId> SilenceWatch::take_lost(Time now) {
  std::vector<NodeId> lost;
  std::erase_if(lost_at_, [&](const auto& item) {
    if (now < item.second) return false;
    lost.push_back(item.first);
    return true;
  });
  return lost;
}

}  // namespace sft::core
