// Functions that check if the limits of the process suffice for objects that are about to be opened. If a
// limit were exceeded, Cyclone DDS would end the process, and other functions would fail with errors that
// name only a symptom.
#pragma once

#include <cstddef>

#include "sft/result.h"

namespace sft::core {

/// Returns Errc::limit_exceeded if a limit does not allow these numbers; the error names the limit and how
/// to raise it. To find out, the function opens `descriptors` files, reserves the addresses that `threads`
/// threads need, and starts `threads` threads. It starts none if no limit is near. Then it releases
/// everything.
Result<void> check_room_for(std::size_t descriptors, std::size_t threads);

/// Returns Errc::limit_exceeded if this process has fewer than `descriptors` free file descriptors with
/// numbers that select(2) can take. The C library ends a program that calls select() with a greater number.
Result<void> check_room_for_select(std::size_t descriptors);

/// Returns true if no file is open except for the standard streams.
bool has_no_open_files();

/// Raises the limits of this process, each as far as an ordinary account can, and resets its priority to
/// the default. It is meant for a service that a program has started, since the service inherits the limits
/// of the program. Returns Errc::limit_exceeded if the process then still has fewer than `descriptors` file
/// descriptors, or if the system would end it after some processor time.
Result<void> raise_inherited_limits(std::size_t descriptors);

/// Returns Errc::limit_exceeded if this process must not write a file of that size (RLIMIT_FSIZE). If it
/// did, the system would end the process by a signal.
Result<void> check_file_size(std::size_t bytes);

}  // namespace sft::core
