// Counts what the whole process allocates, in programs that link process_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Calls of operator new by all threads so far.
std::uint64_t process_allocations();

/// Begins to note where the first few allocations come from.
void note_allocations();
/// Stops noting, and writes what was noted to stderr: one call stack each.
void print_allocations();

}  // namespace sft::test
