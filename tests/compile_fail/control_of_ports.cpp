// Must compile: correct uses of the transmissions and batches that other snippets misuse.
#include "tests/compile_fail/ports.h"

using namespace sft::core;

SendStatus send_in_a_batch(NetworkWriter& port, const SampleHandle& sample) {
  Batch batch = port.batch(BatchTimeout::fresh);
  Transmission transmission = port.begin();
  const SendStatus status = std::move(transmission).send(sample, Reach::fallback_routes_too);
  port.begin().miss();
  return std::move(batch).flush() == 0 ? status : SendStatus::dropped;
}
