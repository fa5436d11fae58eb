// Counts what the whole process allocates, in programs that link process_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Calls of operator new by all threads so far.
std::uint64_t process_allocations();

}  // namespace sft::test
