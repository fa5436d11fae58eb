// The publishers and subscribers that a node's program holds, to be looked at all at once. Any thread.
#pragma once

#include <mutex>
#include <vector>

#include "core/publish/publisher_core.h"
#include "core/subscribe/subscriber_core.h"
#include "sft/snapshot.h"

namespace sft::core {

/// Keeps nobody alive: whoever was entered is struck off before it goes.
class EndpointRoster {
 public:
  void enter(const PublisherCore& publisher);
  void enter(SubscriberCore& subscriber);
  void strike_off(const PublisherCore& publisher);
  void strike_off(const SubscriberCore& subscriber);

  /// Adds what they know of themselves, in the order in which they were entered.
  void describe(NodeSnapshot& snapshot);

 private:
  std::mutex mutex_;  // also while they are asked, which takes locks of theirs; nothing else happens under it
  std::vector<const PublisherCore*> publishers_;
  std::vector<SubscriberCore*> subscribers_;
};

}  // namespace sft::core
