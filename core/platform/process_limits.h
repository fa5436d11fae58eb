// Functions that check whether the limits of the process leave room for what is about to be opened. Without
// room, Cyclone DDS would end the process, and other functions would fail with errors that name only a
// symptom.
#pragma once

#include <cstddef>

#include "sft/result.h"

namespace sft::core {

/// Returns Errc::limit_exceeded, which names the limit and how to raise it, if there is no room. To find out,
/// the function opens `descriptors` files, reserves the addresses that `threads` threads need, and starts
/// that many threads unless all limits are far away. Then it releases all of this.
Result<void> check_room_for(std::size_t descriptors, std::size_t threads);

/// Returns Errc::limit_exceeded if this process has fewer than `descriptors` free file descriptors with
/// numbers that select(2) can take. The C library ends a program that calls select() with a greater one.
Result<void> check_room_for_select(std::size_t descriptors);

/// Returns true if no file is open except for the standard streams.
bool has_no_open_files();

/// Raises the limits of this process, each as far as an ordinary account can, and resets its priority to the
/// default. For a service that a program has started, whose limits it inherits. Returns Errc::limit_exceeded
/// if it then still has fewer than `descriptors` file descriptors, or if the system would end it after some
/// processor time.
Result<void> raise_inherited_limits(std::size_t descriptors);

/// Returns Errc::limit_exceeded if this process must not write files of that size (RLIMIT_FSIZE). The system
/// would end it by a signal.
Result<void> check_file_size(std::size_t bytes);

}  // namespace sft::core
