// Hears the unmodified DDS writers of the topic of one reader. It has a DDS reader while the node has a
// participant for it. The reader is in the partition of the writers only while one that it can hear is there.
// Otherwise the readers and writers of SFT's nodes, which DDS cannot tell from others, would match each
// other. Used by the agent only.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/negotiation/hearing.h"
#include "core/node/node_context.h"
#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/subscribe/subscriber_core.h"
#include "core/subscribe/vanilla_inlet.h"
#include "core/vanilla/vanilla_reader.h"

namespace sft::core {

class VanillaHearing {
 public:
  /// The DDS reader goes on to hear for this time after the last such writer has gone, since samples of the
  /// writer may still arrive, and writers restart.
  static constexpr std::chrono::seconds kept{2};

  /// All outlive this object. `feed` belongs to `core`.
  VanillaHearing(NodeContext& node, SubscriberCore& core, Feed& feed);

  /// Opens what is needed now, and closes what is not needed any more.
  void reconcile(Time now);
  /// Returns all such writers, heard or not.
  std::vector<Hearing> hearing() const;
  /// Returns true if reconcile() has to be called.
  bool is_due(Time now) const;

 private:
  struct Writer {
    VanillaEndpoint endpoint;
    std::string why_not;  ///< empty: it is heard
  };

  void look_at_writers();
  bool is_wanted() const;
  bool is_heard_no_more(Time now) const;
  std::string node_of(const VanillaEndpoint& writer) const;
  void open_reader(bool hears, Time now);
  void name_faults();
  void warn(const std::string& text) const;

  NodeContext& node_;
  SubscriberCore& core_;
  Feed& feed_;
  std::shared_ptr<VanillaInlet> inlet_;  ///< null until there was a DDS reader
  std::unique_ptr<VanillaReader> reader_;
  std::vector<Writer> writers_;
  std::set<std::string> unheard_;  ///< the reasons that the log has named
  std::set<RawFault> faults_;      ///< those that the log has named
  std::uint64_t changes_ = 0;      ///< VanillaEndpoints::changes() when the writers were looked at
  Time wanted_at_{};               ///< when such a writer was there last
  Retry opening_;
};

}  // namespace sft::core
