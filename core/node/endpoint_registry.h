// The publishers and subscribers that the program holds on a node, for a snapshot of all of them. Any
// thread may use it.
#pragma once

#include <cstddef>
#include <vector>

#include "core/publish/publisher_core.h"
#include "core/subscribe/subscriber_core.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/snapshot.h"

namespace sft::core {

/// The list of publishers and subscribers. The list does not own them: each must be removed before it is
/// destroyed.
class EndpointRegistry {
 public:
  void enter(const PublisherCore& publisher);
  void enter(SubscriberCore& subscriber);
  void strike_off(const PublisherCore& publisher);
  void strike_off(const SubscriberCore& subscriber);

  std::size_t size();
  /// Adds the status of all endpoints to the snapshot, in the order in which they were entered.
  void describe(NodeSnapshot& snapshot);

 private:
  // This mutex is also held while the status of the endpoints is read, which locks mutexes of the
  // endpoints.
  Mutex mutex_ SFT_ACQUIRED_BEFORE(lock_order::endpoints);
  std::vector<const PublisherCore*> publishers_ SFT_GUARDED_BY(mutex_);
  std::vector<SubscriberCore*> subscribers_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
