#include "core/silence_watch.h"

namespace sft::core {

bool SilenceWatch::is_lost(NodeId node, Now now) const {
  const auto heard = nodes_.find(node);
  return heard == nodes_.end() || now - heard->second >= lease_;
}

std::vector<NodeId> SilenceWatch::take_lost(Now now) {
  std::vector<NodeId> lost;
  std::erase_if(nodes_, [&](const auto& item) {
    if (now - item.second < lease_) return false;
    lost.push_back(item.first);
    return true;
  });
  return lost;
}

}  // namespace sft::core
