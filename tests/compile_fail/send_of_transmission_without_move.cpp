// expect: (as 'this' argument discards qualifiers|'send' is an lvalue)
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  auto transmission = port.begin();
  return transmission.send(sample);
}
