// Compiles: what the snippets of this folder do wrong, done right.
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

using namespace sft::core;

class Endpoint {
 public:
  void take_in_order() {
    const Lock lock(mutex_);
    const Lock queue_lock(queue_mutex_);
  }

 private:
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  Mutex queue_mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoint) SFT_ACQUIRED_BEFORE(lock_order::queues);
};
