// expect: (Transmission.* is private within|calling a private constructor of) .*
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  return sft::core::Transmission(port).send(sample);
}
