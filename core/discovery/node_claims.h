// Keeps which participants say that a node lives, and decides when the node is lost. On each link the first
// participant that speaks for a node is believed, or the one after it once that is silent. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class NodeClaims {
 public:
  /// `speakers` outlives this object.
  NodeClaims(const Speakers& speakers, std::size_t nodes_max) : speakers_(speakers), nodes_max_(nodes_max) {}

  /// The speaker says that the node lives; returns true if it is believed. `silence`: after that nobody
  /// speaks.
  bool asserted(NodeId node, const Speaker& speaker, std::chrono::milliseconds silence, Time now);
  using LeaseOf = std::function<std::chrono::milliseconds(NodeId)>;
  /// Cyclone has heard nothing of the node on that link for its lease. Returns true if the node is lost now.
  bool unheard(NodeId node, LinkId link, const LeaseOf& lease_of, Time now);
  void participant_departed(const Speaker& speaker);
  /// Nobody is heard on that link any more. forget_link() follows after take_lost().
  void link_dropped(LinkId link);
  void forget_link(LinkId link);

  struct Lives {
    std::size_t living = 0;    ///< nodes of which somebody says that they live
    bool has_rivals = false;   ///< several speakers say that the same node lives
    bool awaits_loss = false;  ///< some node has its lease to return, and is lost then
  };
  Lives lives() const;
  /// True if this speaker is the one that is believed on its link to say that the node lives.
  bool is_vouched_for(NodeId node, const Speaker& speaker) const;
  /// True if take_lost() has reported the node as lost, and the node has given no sign of life since then.
  bool is_lost(NodeId node) const;

  /// The nodes that are lost by now, each told once. A node whose speakers all fell silent is lost at once.
  /// Else a link was dropped or made anew: then the node has its lease to return by another one.
  std::vector<NodeId> take_lost(const LeaseOf& lease_of, Time now);
  /// Ends what silent speakers say. Of those that give pulses nobody else tells that the lease is over, since
  /// Cyclone's lease is longer. Of others Cyclone does, but not if somebody else has disposed of the signs of
  /// life.
  void end_silent(const LeaseOf& lease_of, Time now);
  /// Forgets nodes that were lost by that time, unless `is_needed` returns true for them.
  void forget_before(Time before, const std::function<bool(NodeId)>& is_needed);

 private:
  /// Time for a link that does not hear the signs of life to be made anew (hearing_watch.h).
  static constexpr std::chrono::seconds slack{4};

  struct Claim {
    Speaker speaker;
    Time heard{};  ///< when the speaker said last that this node lives; it may speak for others, too
    bool alive = true;
  };
  struct Node {
    std::vector<Claim> claims;
    std::optional<Time> lost_at{};
    bool lost = false;
  };
  static Time last_heard(const Node& node);
  bool is_lost(NodeId id, Node& node, const LeaseOf& lease_of, Time now) const;

  const Speakers& speakers_;
  const std::size_t nodes_max_;
  std::map<NodeId, Node> nodes_;
};

}  // namespace sft::core
