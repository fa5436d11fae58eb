// expect: invalid invocation of method 'send' .*'consumed' state
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  sft::core::Transmission transmission = port.begin();
  static_cast<void>(std::move(transmission).send(sample));
  return std::move(transmission).send(sample);
}
