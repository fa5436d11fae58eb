// Counts the allocations of the whole process, in programs that link process_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Returns the number of calls of operator new by all threads so far.
std::uint64_t process_allocations();

/// Begins to note the call stacks of the first few allocations.
void note_allocations();
/// Stops noting, and writes the call stacks to stderr.
void print_allocations();

}  // namespace sft::test
