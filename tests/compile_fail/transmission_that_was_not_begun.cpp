// expect: (Transmission.* is private within|calling a private constructor of) .*
#include "core/seam/writer_port.h"

auto misuse(sft::core::NetworkWriter& port, const sft::core::SampleHandle& sample) {
  return sft::core::Transmission(port).send(sample);
}
