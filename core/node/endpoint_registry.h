// The publishers and subscribers that the program of a node holds, for a snapshot of all of them. Any thread.
#pragma once

#include <vector>

#include "core/publish/publisher_core.h"
#include "core/subscribe/subscriber_core.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/snapshot.h"

namespace sft::core {

/// Does not own the endpoints. Each must be struck off before it is destroyed.
class EndpointRegistry {
 public:
  void enter(const PublisherCore& publisher);
  void enter(SubscriberCore& subscriber);
  void strike_off(const PublisherCore& publisher);
  void strike_off(const SubscriberCore& subscriber);

  /// Adds the status of all endpoints, in the order in which they were entered.
  void describe(NodeSnapshot& snapshot);

 private:
  Mutex mutex_ SFT_ACQUIRED_BEFORE(lock_order::endpoints);  // also held while the endpoints are asked for
                                                            // their status, which takes their own locks
  std::vector<const PublisherCore*> publishers_ SFT_GUARDED_BY(mutex_);
  std::vector<SubscriberCore*> subscribers_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
