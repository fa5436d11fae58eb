// expect: [Cc]ycle in acquired_before/after dependencies
#include "tests/compile_fail/ports.h"

using namespace sft::core;

class Endpoint {
 public:
  void misuse() { const Lock lock(mutex_); }

 private:
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::queues) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
};
