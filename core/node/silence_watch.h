// Decides which nodes are lost that have said something, but have not given a sign of life since. Pure.
//
// Discovery watches the signs of life of a node from the first one on, and tells once if they fail to come.
// Anything else that a node says is as good a sign, but discovery does not watch it. This class does: before
// the first sign of life, and when discovery has told that there are none any more.
#pragma once

#include <chrono>
#include <map>
#include <set>
#include <vector>

#include "core/control/control.h"
#include "core/platform/clock.h"

namespace sft::core {

class SilenceWatch {
 public:
  /// The node has said something else than that it lives. While discovery does not watch the node, it is lost
  /// if nothing is heard of it for `lease`.
  void heard(NodeId node, std::chrono::milliseconds lease, Time now) { lost_at_[node] = now + lease; }
  /// The node has said that it lives: discovery watches it.
  void lives(NodeId node);
  /// Discovery misses the node's signs of life. True if the node is lost; if not, take_lost() may tell it
  /// later.
  bool is_lost(NodeId node, Time now);
  /// The nodes that discovery does not watch, and of which nothing more has come in time.
  std::vector<NodeId> take_lost(Time now);

 private:
  std::map<NodeId, Time> lost_at_;
  std::set<NodeId> watched_;  ///< by discovery
};

}  // namespace sft::core
