// Child processes: what a program has to do besides fork().
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <vector>

#include "sft/result.h"

namespace sft::hosts {

/// Runs `body` in a child process and waits for its end. `body` returns its result, or executes a program
/// that writes to `output`; if that program fails, what it wrote is the error.
Result<void> in_child(const std::function<Result<void>(int output)>& body);

/// Closes all descriptors but the standard ones and `kept`. A forked process has copies of everything that
/// its parent had open, and a socket reports that its other end is closed only when every copy of that end is
/// closed.
void close_descriptors_except(std::vector<int> kept);

/// Blocks these signals and no others, so that the process can wait for them.
void block_only(std::initializer_list<int> signals);

/// Waits until that child has ended.
void reap(pid_t child);

/// Asks all children to end, kills those that have not ended after `timeout`, and returns once none is left.
void end_children(std::chrono::milliseconds timeout);

}  // namespace sft::hosts
