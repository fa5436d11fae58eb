// Decides when a node has a participant for unmodified nodes of DDS and ROS 2. It has one while it has
// publishers or subscribers and, if the option is `automatic`, only while such nodes are found. Used by the
// agent only.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/node/vanilla_view.h"
#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"
#include "core/vanilla/vanilla_domain.h"
#include "sft/options.h"

namespace sft::core {

class VanillaAccess {
 public:
  /// The time for which the participant is kept after the last such node has departed, because nodes
  /// restart, and tools run for a moment only.
  static constexpr std::chrono::seconds kept{30};

  struct Setup {
    NodeOptions::VanillaDds choice = NodeOptions::VanillaDds::never;
    VanillaPlan plan{};
    std::string node{};       ///< the full name of the node, such as "left/camera"
    ThreadSettings sender{};  ///< the settings of the threads that pass samples to DDS writers
    std::function<Result<std::shared_ptr<VanillaDomain>>(const VanillaPlan&)> open = &VanillaDomain::of;
    std::function<bool(std::uint32_t domain)> program_speaks = &program_speaks_dds;
    /// Called by any thread when readers of a publisher, or writers, have appeared or departed. Must return
    /// at once.
    std::function<void()> endpoints_changed{};
  };
  VanillaAccess(Setup setup, NodeLog& log);

  /// `heard` contains counts of the DDS nodes that the links have found. `is_needed` is true while the node
  /// has a publisher or a subscriber, or while the program asks the node for the whole domain. Returns true
  /// if the domain or its endpoints have changed.
  bool look(const Discovery::Vanilla& heard, bool is_needed, Time now);
  /// Returns the latest time of the next call of look(), or Time::max() if no call is needed without an
  /// event.
  Time next_look() const { return next_look_; }

  /// Returns the domain with the participant, or null while there is no participant.
  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  /// Returns the unmodified writers in the domain, or null while there is no participant.
  const VanillaEndpoints* writers() const { return writers_.get(); }
  /// Returns true if the agent may now wait for a short time, which it may do once a second.
  bool may_wait(Time now) {
    const bool may = now >= waits_again_at_;
    if (may) waits_again_at_ = now + std::chrono::seconds(1);
    return may;
  }
  /// Returns true if this endpoint is an unmodified writer of the topic.
  bool knows_writer(EndpointId id, const std::string& topic) const;
  /// Returns the unmodified writers of that type whose topics nodes of SFT can have.
  std::vector<Discovery::KnownPublisher> publishers_of(std::string_view type_name) const;
  /// Returns the endpoints that the participant has discovered, or an empty view if there is no
  /// participant.
  VanillaView view() const;
  // The functions for the DDS readers and writers of the node in the graph of ROS 2. They are collected
  // whenever all endpoints of the node are reconciled.
  void forget_endpoints();
  void add_reader(const Guid& reader) { shown_.readers.push_back(reader); }
  void add_writer(const Guid& writer) { shown_.writers.push_back(writer); }
  /// Shows the node with these endpoints in the graph.
  void show_endpoints();
  const Setup& setup() const { return setup_; }
  DdsNames names() const { return setup_.plan.names; }

 private:
  bool is_wanted(const Discovery::Vanilla& heard, Time now);
  bool may_serve(const Discovery::Vanilla& heard);
  bool open(Time now);

  const Setup setup_;
  NodeLog& log_;
  std::shared_ptr<VanillaDomain> domain_;
  std::unique_ptr<VanillaEndpoints> writers_;
  std::unique_ptr<RosGraph::LocalNode> in_graph_;
  ParticipantEntities::Node shown_;
  Retry opening_;
  Time heard_at_{};            ///< the last time at which such a node was found; Time{}: never
  std::uint64_t changes_ = 0;  ///< the number of changes of readers and writers at the last call of look()
  std::uint64_t came_ = 0;     ///< Discovery::Vanilla::came when the program was checked last
  bool program_speaks_dds_ = false;  ///< the result of that check
  bool graph_is_divided_ = false;    ///< the value at the last call of show_endpoints()
  Time next_look_ = Time::max();
  Time waits_again_at_{};
};

}  // namespace sft::core
