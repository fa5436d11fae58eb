// Makes the files of the daemon's segments in /dev/shm.
#pragma once

#include <cstddef>
#include <string>

#include "sft/result.h"

namespace sft::shm {

/// Makes /dev/shm/NAME with `bytes` zeros, for this account and the group of the file. The system has set
/// the memory aside when the call returns, so nobody who maps the file finds that there is no more. But a
/// page is cleared only when it is used for the first time. To write zeros to all pages would take most of
/// the time in which the daemon starts. Errc::address_in_use if anything has this name, Errc::out_of_memory
/// if there is no space; then no file remains.
Result<void> make_segment_file(const std::string& name, std::size_t bytes);

}  // namespace sft::shm
