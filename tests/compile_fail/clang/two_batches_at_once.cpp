// expect: acquiring batch 'port' that is already held
#include "tests/compile_fail/ports.h"

void misuse(sft::core::NetworkWriter& port) {
  sft::core::Batch batch = port.batch(sft::core::BatchTimeout::fresh);
  sft::core::Batch another = port.batch(sft::core::BatchTimeout::fresh);
}
