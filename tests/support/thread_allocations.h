// Counts what the calling thread allocates, in programs that link thread_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Calls of operator new by this thread so far.
std::uint64_t thread_allocations();

}  // namespace sft::test
