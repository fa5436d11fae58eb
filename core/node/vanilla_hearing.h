// Receives samples of the unmodified DDS writers of the topic of one reader. It has a DDS reader while the
// node has a participant for it. The DDS reader is in the partition of the writers only while there is a
// writer from which it can receive. Otherwise the DDS readers and DDS writers of SFT's nodes would match
// each other, because DDS cannot distinguish them from others. Used by the agent only.
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
  /// The time for which the DDS reader continues to receive after the last such writer has departed, since
  /// samples of the writer may still arrive, and writers may restart.
  static constexpr std::chrono::seconds kept{2};

  /// All arguments must outlive this object. `feed` belongs to `core`.
  VanillaHearing(NodeContext& node, SubscriberCore& core, Feed& feed);

  /// Opens objects that are needed now, and closes objects that are not needed any more.
  void reconcile(Time now);
  /// Returns the state of all such writers, including writers from which nothing is received.
  std::vector<Hearing> hearing() const;
  /// Returns true if reconcile() has to be called.
  bool is_due(Time now) const;

 private:
  struct Writer {
    VanillaEndpoint endpoint;
    /// The reason why nothing is received from the writer; empty: its samples are received
    std::string why_not;
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
  std::shared_ptr<VanillaInlet> inlet_;  ///< null until the first DDS reader was opened
  std::unique_ptr<VanillaReader> reader_;
  std::vector<Writer> writers_;
  /// The reasons that were logged, for writers from which nothing is received
  std::set<std::string> unheard_;
  std::set<RawFault> faults_;  ///< the faults that were logged
  /// The value of VanillaEndpoints::changes() at the last examination of the writers
  std::uint64_t changes_ = 0;
  Time wanted_at_{};  ///< the last time at which such a writer existed
  Retry opening_;
};

}  // namespace sft::core
