// expect: (flush.* is private within this context|'flush' is a private member)
#include "core/seam/writer_port.h"

auto misuse(sft::core::NetworkWriter& port) { return port.flush(); }
