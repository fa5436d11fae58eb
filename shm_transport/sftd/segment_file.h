// The files of the daemon's segments in /dev/shm.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::shm {

struct FilePart {
  std::size_t offset = 0;
  std::size_t bytes = 0;
};

struct SegmentFile {
  core::FileDescriptor file;
  std::size_t bytes = 0;
  /// The parts of the file that have no memory until a program requests it from the system. Each part
  /// consists of whole pages. The parts are in the order of the file.
  std::vector<FilePart> on_demand{};

  /// Returns all other parts of the file.
  std::vector<FilePart> at_once() const;
};

/// Makes /dev/shm/NAME with `bytes` zeros, for this account and the group of the file. When the call
/// returns, the system has set the memory aside, so a process that maps the file does not run out of memory
/// in it. But a page is cleared only when it is used for the first time: writing zeros to all pages would
/// take most of the time in which the daemon starts. Errc::address_in_use: the name is taken.
/// Errc::out_of_memory: there is no space, and no file remains.
Result<SegmentFile> make_segment_file(const std::string& name, std::size_t bytes);
/// Makes a segment file like make_segment_file(), but without memory. The caller then has to set aside
/// SegmentFile::at_once().
Result<SegmentFile> make_segment_file_without_memory(const std::string& name, std::size_t bytes);
/// Sets aside SegmentFile::at_once(). Errc::out_of_memory if there is no space.
Result<void> set_aside(const SegmentFile& segment, const std::string& name);

/// Clears the pages of this part of the file that were not used yet, and changes no byte. Returns false if
/// the system refuses to clear pages. No mapping is touched, so threads that map memory during the call do
/// not wait.
bool clear_pages(const SegmentFile& segment, std::size_t offset, std::size_t bytes);

}  // namespace sft::shm
