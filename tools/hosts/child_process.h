// Functions for child processes that programs need in addition to fork().
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <vector>

#include "sft/result.h"

namespace sft::hosts {

/// Runs `body` in a child process and waits for its end. `body` returns its result, or executes a program
/// that writes to `output`. If that program fails, its output is the error.
Result<void> in_child(const std::function<Result<void>(int output)>& body);

/// Closes all descriptors except the standard descriptors and `kept`. A forked process has copies of
/// everything that its parent had open. A socket reports that its other end is closed only when every copy
/// of that end is closed.
void close_descriptors_except(std::vector<int> kept);

/// Blocks these signals and unblocks all others, so that the process can wait for the blocked signals.
void block_only(std::initializer_list<int> signals);

/// Waits until that child has ended.
void reap(pid_t child);

/// Sends all children a request to end, kills those that have not ended after `timeout`, and returns once
/// no child is left.
void end_children(std::chrono::milliseconds timeout);

}  // namespace sft::hosts
