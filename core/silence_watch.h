// Nodes that discovery takes for silent, although something else of them has come lately: whether they are to
// be taken for lost. Pure.
//
// Discovery watches their signs of life, and tells once that these fail to come; whatever else a node says is
// as good a sign.
#pragma once

#include <chrono>
#include <map>
#include <vector>

#include "core/control.h"

namespace sft::core {

class SilenceWatch {
 public:
  using Now = std::chrono::steady_clock::time_point;

  /// `lease`: how long nothing at all may be heard of a node.
  explicit SilenceWatch(std::chrono::milliseconds lease) : lease_(lease) {}

  /// It has said something else than that it lives. `was_lost`: discovery does not listen for its end any
  /// more.
  void heard(NodeId node, Now now, bool was_lost);
  /// It has said that it lives: discovery listens.
  void lives(NodeId node) { nodes_.erase(node); }
  /// Discovery takes it for silent. Whether it is lost; if not, it may be told by take_lost() later.
  bool is_lost(NodeId node, Now now);
  /// Those of which nothing more has come meanwhile.
  std::vector<NodeId> take_lost(Now now);

 private:
  struct Heard {
    Now at{};
    bool silent = false;  ///< as discovery takes it
  };
  std::chrono::milliseconds lease_;
  std::map<NodeId, Heard> nodes_;  ///< those heard within a lease
};

}  // namespace sft::core
