// expect: invalid invocation of method 'send' .*'consumed' state
#include <utility>

#include "core/seam/writer_port.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  sft::core::Transmission transmission = port.begin();
  static_cast<void>(std::move(transmission).send(sample));
  return std::move(transmission).send(sample);
}
