// Decides when a node has a participant for unmodified nodes of DDS and ROS 2: while the node has publishers
// or subscribers and, with `automatic`, only while such nodes are found. Used by the agent only.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
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
  /// The participant is kept for this time after the last such node has gone, because nodes restart, and
  /// tools run for a moment only.
  static constexpr std::chrono::seconds kept{30};

  struct Setup {
    NodeOptions::VanillaDds choice = NodeOptions::VanillaDds::never;
    VanillaPlan plan{};
    std::string node{};       ///< the full name of the node, as "left/camera"
    ThreadSettings sender{};  ///< settings of the threads that hand samples over
    std::function<Result<std::shared_ptr<VanillaDomain>>(const VanillaPlan&)> open = &VanillaDomain::of;
    std::function<bool(std::uint32_t domain)> program_speaks = &program_speaks_dds;
    /// Called by any thread when readers of some publisher, or writers, have come or gone. Must return at
    /// once.
    std::function<void()> endpoints_changed{};
  };
  VanillaAccess(Setup setup, NodeLog& log);

  /// `heard` counts the DDS nodes that the links have found. `is_needed` is true while the node has a
  /// publisher or a subscriber, or tells the program of the whole domain. Returns true if the domain or its
  /// endpoints have changed.
  bool look(const Discovery::Vanilla& heard, bool is_needed, Time now);
  /// Returns the time by which look() has to be called again; Time::max() if nothing changes by itself.
  Time next_look() const { return next_look_; }

  /// Null while the node has no such participant.
  const std::shared_ptr<VanillaDomain>& domain() const { return domain_; }
  /// The unmodified writers in the domain; null while the node has no such participant.
  const VanillaEndpoints* writers() const { return writers_.get(); }
  /// Returns true if the agent may now wait for a moment, which is the case once a second.
  bool may_wait(Time now) {
    const bool may = now >= waits_again_at_;
    if (may) waits_again_at_ = now + std::chrono::seconds(1);
    return may;
  }
  /// Returns true if that endpoint is an unmodified writer of the topic.
  bool knows_writer(EndpointId id, const std::string& topic) const;
  /// Returns what the participant has discovered; nothing while there is none.
  VanillaView view() const;
  // The DDS readers and writers of the node in the graph of ROS 2. They are collected whenever all endpoints
  // of the node are reconciled.
  void forget_endpoints();
  void add_reader(const Guid& reader) { shown_.readers.push_back(reader); }
  void add_writer(const Guid& writer) { shown_.writers.push_back(writer); }
  /// Shows the node with them.
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
  Time heard_at_{};                  ///< when such a node was found last; Time{}: never
  std::uint64_t changes_ = 0;        ///< of readers and writers, at the last look
  std::uint64_t came_ = 0;           ///< Discovery::Vanilla::came at the last look at the program
  bool program_speaks_dds_ = false;  ///< the result of that look
  bool graph_is_divided_ = false;    ///< at the last show_endpoints()
  Time next_look_ = Time::max();
  Time waits_again_at_{};
};

}  // namespace sft::core
