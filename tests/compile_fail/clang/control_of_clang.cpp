// Must compile: correct uses of what the other snippets of this folder misuse.
#include "tests/compile_fail/ports.h"

using namespace sft::core;

SendStatus send_in_batches(NetworkWriter& port, const SampleHandle& sample) {
  {
    Batch batch = port.batch(BatchTimeout::fresh);
    port.begin().miss();
    static_cast<void>(std::move(batch).flush());
  }
  Batch batch = port.batch(BatchTimeout::continued);
  Transmission transmission = port.begin();
  return std::move(transmission).send(sample);
}

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
