// Processes: what fork() leaves to do by hand.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <vector>

#include "sft/typesupport/result.h"

namespace sft::demo {

/// Runs `body` in a child process and returns its result.
Result<void> in_child(const std::function<Result<void>()>& body);

/// Closes all descriptors but the standard ones and `kept`. A forked process has copies of everything that
/// its parent had open, and a socket only reports its other end closed once every copy of that is.
void close_descriptors_except(std::vector<int> kept);

/// The processes that this one is the parent of, by birth or adoption.
std::vector<pid_t> children();

/// Asks all children to end, kills those that have not after `patience`, and returns once none is left.
void end_children(std::chrono::milliseconds patience);

}  // namespace sft::demo
