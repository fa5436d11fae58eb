// expect: (as 'this' argument discards qualifiers|'miss' is an lvalue)
#include "core/seam/writer_port.h"

void misuse(sft::core::NetworkWriter& port) {
  auto transmission = port.begin();
  transmission.miss();
}
