// Nodes that have said something, and not yet after that that they live: whether they are lost. Pure.
//
// Discovery watches the signs of life of nodes from the first that has come, and tells once that they fail to
// come. Whatever else a node says is as good a sign, but its end is ours to watch until the next.
#pragma once

#include <chrono>
#include <map>
#include <vector>

#include "core/control/control.h"

namespace sft::core {

class SilenceWatch {
 public:
  using Now = std::chrono::steady_clock::time_point;

  /// It has said something else than that it lives. `lease`: how long nothing at all may be heard of it.
  void heard(NodeId node, std::chrono::milliseconds lease, Now now) { lost_at_[node] = now + lease; }
  /// It has said that it lives: discovery watches it.
  void lives(NodeId node) { lost_at_.erase(node); }
  /// Discovery misses its signs. Whether it is lost; if not, it may be told by take_lost() later.
  bool is_lost(NodeId node, Now now) const;
  /// Those of which nothing more has come meanwhile.
  std::vector<NodeId> take_lost(Now now);

 private:
  std::map<NodeId, Now> lost_at_;
};

}  // namespace sft::core
