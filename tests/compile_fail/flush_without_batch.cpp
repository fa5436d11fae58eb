// expect: (flush.* is private within this context|'flush' is a private member)
#include "tests/compile_fail/ports.h"

auto misuse(sft::core::NetworkWriter& port) { return port.flush(); }
