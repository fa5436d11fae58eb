// Counts the allocations of the whole process, in programs that link process_allocations.cpp.
#pragma once

#include <cstdint>

namespace sft::test {

/// Returns the number of calls of operator new by all threads so far.
std::uint64_t process_allocations();

/// Begins to record the call stacks of the first few allocations.
void note_allocations();
/// Stops recording, and writes the recorded call stacks to the standard error.
void print_allocations();

}  // namespace sft::test
