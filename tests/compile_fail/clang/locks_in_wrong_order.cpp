// expect: mutex 'mutex_' must be acquired before 'queue_mutex_'
#include "tests/compile_fail/ports.h"

using namespace sft::core;

class Endpoint {
 public:
  void misuse() {
    const Lock queue_lock(queue_mutex_);
    const Lock lock(mutex_);
  }

 private:
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  Mutex queue_mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoint) SFT_ACQUIRED_BEFORE(lock_order::queues);
};
