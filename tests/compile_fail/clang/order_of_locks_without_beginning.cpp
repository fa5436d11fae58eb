// expect: [Cc]ycle in acquired_before/after dependencies
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

using namespace sft::core;

class Endpoint {
 public:
  void misuse() { const Lock lock(mutex_); }

 private:
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::queues) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
};
