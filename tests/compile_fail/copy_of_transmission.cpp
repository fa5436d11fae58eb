// expect: (use of deleted function .*Transmission|call to (implicitly-deleted|deleted)? ?copy constructor)
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  auto transmission = port.begin();
  auto second = transmission;
  return std::move(second).send(sample);
}
