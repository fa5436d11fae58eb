// A segment of shared memory that is mapped in this process.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::shm {

/// Returns whether these bytes are within the memory.
bool contains(std::span<const std::byte> memory, const void* data, std::size_t size);

class Mapping {
 public:
  /// Maps the first `bytes` of /dev/shm/NAME. The file must belong to `owner`, the account of the daemon.
  /// The reason is that the owner of a file can truncate it, which ends every process that reads beyond the
  /// new end.
  static Result<Mapping> open(const std::string& name, std::size_t bytes, bool writable, uid_t owner);
  Mapping(Mapping&& other) noexcept
      : memory_(std::exchange(other.memory_, {})), group_(other.group_), file_(std::move(other.file_)) {}
  Mapping& operator=(Mapping&&) = delete;
  ~Mapping();

  std::span<std::byte> bytes() const { return memory_; }
  /// Returns the group of the file.
  gid_t group() const { return group_; }
  /// Returns the descriptor of the file; -1 if the segment is mapped for reading only.
  int file() const { return file_.get(); }
  bool contains(const void* data, std::size_t size) const { return shm::contains(memory_, data, size); }

 private:
  Mapping(std::span<std::byte> memory, gid_t group, core::FileDescriptor file)
      : memory_(memory), group_(group), file_(std::move(file)) {}
  std::span<std::byte> memory_;
  gid_t group_;
  core::FileDescriptor file_;
};

}  // namespace sft::shm
