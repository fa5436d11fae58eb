// These functions check whether the limits of the process leave room for what is about to be opened. Cyclone
// DDS ends the process if they do not, and elsewhere the error would name a symptom.
#pragma once

#include <cstddef>

#include "sft/result.h"

namespace sft::core {

/// Errc::limit_exceeded says which limit it is, and how to raise it. The function opens `descriptors` files,
/// reserves the addresses that `threads` threads need, starts that many threads unless all limits are far
/// away, and gives all of it back.
Result<void> check_room_for(std::size_t descriptors, std::size_t threads);

/// Errc::limit_exceeded if this process does not have so many free file descriptors with numbers that
/// select(2) can take: a program that calls it with a greater one is ended by the C library.
Result<void> check_room_for_select(std::size_t descriptors);

/// True if no number but those of the standard streams is that of an open file.
bool has_no_open_files();

/// Raises the limits of this process, each as far as an ordinary account can, and takes its priority back to
/// the usual one. For a service that a program has started, whose limits it inherits. Errc::limit_exceeded if
/// it then has fewer file descriptors, or if the system would end it after some processor time.
Result<void> raise_inherited_limits(std::size_t descriptors);

/// Errc::limit_exceeded where this process may not write files of that size (RLIMIT_FSIZE): the system would
/// end it by a signal.
Result<void> check_file_size(std::size_t bytes);

}  // namespace sft::core
