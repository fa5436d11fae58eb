// Counts the allocations of the calling thread, in programs that link thread_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Returns the number of calls of operator new by this thread so far.
std::uint64_t thread_allocations();

}  // namespace sft::test
