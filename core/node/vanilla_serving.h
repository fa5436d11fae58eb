// Serves the unmodified DDS readers of one publisher. It has a DDS writer while the node has a participant
// for it. The publisher gets a port while the DDS writer has such readers. Used by the agent only.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include "core/node/node_context.h"
#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/publish/publisher_core.h"
#include "core/vanilla/vanilla_outlet.h"
#include "core/vanilla/vanilla_writer.h"

namespace sft::core {

class VanillaServing {
 public:
  /// The time within which the readers must have acknowledged all samples that were sent.
  static constexpr std::chrono::seconds unanswered_max{5};

  /// Both arguments must outlive this object.
  VanillaServing(NodeContext& node, PublisherCore& core) : node_(node), core_(core) {}
  ~VanillaServing();
  VanillaServing(const VanillaServing&) = delete;
  VanillaServing& operator=(const VanillaServing&) = delete;

  /// Opens objects that are needed now, and closes objects that are not needed any more. Returns true if
  /// the port has changed. Then the caller must pass the new port to the publisher, and call in_force().
  bool reconcile(Time now);
  std::shared_ptr<VanillaPort> port() const { return outlet_; }
  /// Called once the publisher sends by the present port, and does not use the former port any more.
  void in_force();
  /// Checks whether readers acknowledge their samples. Returns true if an object could not be opened and
  /// the next attempt is due.
  bool look(Time now);

 private:
  void open_writer(Time now);
  void start_outlet(Time now);
  void name_complaints();
  void look_at_answers(Time now);
  void failed(const Error& error, Time now);

  NodeContext& node_;
  PublisherCore& core_;
  std::shared_ptr<VanillaWriter> writer_;
  std::shared_ptr<VanillaOutlet> outlet_;
  std::shared_ptr<VanillaOutlet> retired_;  ///< the former port, until in_force() is called
  std::set<std::string> complaints_;        ///< the complaints that were logged
  /// The value of VanillaEndpoints::changes() when complaints were logged last
  std::uint64_t readers_changes_ = 0;
  /// The time of the next wait for acknowledgements, see look_at_answers()
  Time waits_at_ = std::chrono::steady_clock::now() + unanswered_max;
  bool is_answered_ = true;  ///< false: a reader does not acknowledge its samples
  Retry opening_;
};

}  // namespace sft::core
