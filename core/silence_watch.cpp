#include "core/silence_watch.h"

namespace sft::core {

void SilenceWatch::heard(NodeId node, Now now, bool was_lost) {
  Heard& heard = nodes_[node];
  heard.at = now;
  heard.silent |= was_lost;
}

bool SilenceWatch::is_lost(NodeId node, Now now) {
  const auto known = nodes_.find(node);
  if (known == nodes_.end()) return true;
  known->second.silent = true;
  if (now - known->second.at < lease_) return false;
  nodes_.erase(known);
  return true;
}

std::vector<NodeId> SilenceWatch::take_lost(Now now) {
  std::vector<NodeId> lost;
  std::erase_if(nodes_, [&](const auto& item) {
    const auto& [node, heard] = item;
    if (now - heard.at < lease_) return false;
    if (heard.silent) lost.push_back(node);
    return true;
  });
  return lost;
}

}  // namespace sft::core
