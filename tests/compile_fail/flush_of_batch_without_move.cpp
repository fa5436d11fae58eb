// expect: (as 'this' argument discards qualifiers|'flush' is an lvalue)
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port) {
  auto batch = port.batch(sft::core::BatchTimeout::fresh);
  return batch.flush();
}
