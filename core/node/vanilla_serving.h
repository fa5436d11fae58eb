// Serves the unmodified DDS readers of one publisher. It has a DDS writer while the node has a participant
// for it, and a port for the publisher while the writer has such readers. Used by the agent only.
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
  /// All samples that were sent may wait for their acknowledgements for this time.
  static constexpr std::chrono::seconds unanswered_max{5};

  /// Both outlive this object.
  VanillaServing(NodeContext& node, PublisherCore& core) : node_(node), core_(core) {}
  ~VanillaServing();
  VanillaServing(const VanillaServing&) = delete;
  VanillaServing& operator=(const VanillaServing&) = delete;

  /// Opens what is needed now, and closes what is not needed any more. Returns true if the port has changed.
  /// Then the caller must give the new port to the publisher, and call in_force().
  bool reconcile(Time now);
  std::shared_ptr<VanillaPort> port() const { return outlet_; }
  /// Notes that the publisher sends by the present port, and no longer by the former one.
  void in_force();
  /// Watches whether readers acknowledge what they are sent. Returns true if something could not be opened
  /// and may be tried again.
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
  std::shared_ptr<VanillaOutlet> retired_;  ///< the former port, until in_force()
  std::set<std::string> complaints_;        ///< those that the log has named
  std::uint64_t readers_changes_ = 0;       ///< VanillaEndpoints::changes() when the log named them
  Time waits_at_ = std::chrono::steady_clock::now() + unanswered_max;  ///< for answers, see look_at_answers()
  bool is_answered_ = true;  ///< false: some reader does not acknowledge what it is sent
  Retry opening_;
};

}  // namespace sft::core
