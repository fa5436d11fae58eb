// The files of the daemon's segments in /dev/shm.
#pragma once

#include <cstddef>
#include <string>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::shm {

struct SegmentFile {
  core::FileDescriptor file;
  std::size_t bytes = 0;
};

/// Makes /dev/shm/NAME with `bytes` zeros, for this account and the group of the file. The system has set
/// the memory aside when the call returns, so nobody who maps the file finds that there is no more. But a
/// page is cleared only when it is used for the first time. To write zeros to all pages would take most of
/// the time in which the daemon starts. Errc::address_in_use if anything has this name, Errc::out_of_memory
/// if there is no space; then no file remains.
Result<SegmentFile> make_segment_file(const std::string& name, std::size_t bytes);

/// Clears those of these pages that nobody has used yet, and changes no byte. False if the system refuses it.
/// No mapping is touched, so threads that map memory meanwhile do not wait.
bool clear_pages(const SegmentFile& segment, std::size_t offset, std::size_t bytes);

}  // namespace sft::shm
