// expect: (as 'this' argument discards qualifiers|'miss' is an lvalue)
#include "tests/compile_fail/ports.h"

void misuse(sft::core::NetworkWriter& port) {
  auto transmission = port.begin();
  transmission.miss();
}
