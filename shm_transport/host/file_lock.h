// An exclusive lock on a file, which its holder keeps as long as it lives. By such locks, an sftd detects
// another sftd, and nodes notice that their sftd is gone.
//
// The lock is an open-file-description lock of fcntl. Unlike a lock of flock, it can be queried without
// being taken, so that a query never gets in the way of a daemon that starts. Unlike a POSIX lock, it is
// not lost when another descriptor of the file is closed.
//
// A holder has locked its file for writing. A lock for reading means nothing: any account that may read the
// file can take one, even on the file of a dead holder.
#pragma once

#include <string>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::shm {

using Descriptor = core::FileDescriptor;

class FileLock {
 public:
  /// Makes a new, empty file at `path` and locks it. A file that a dead process left there is replaced and
  /// never reused, because a process that still has it open must not take this holder for the former
  /// holder. Any other object at the path is replaced as well, if this account may remove it.
  /// Errc::address_in_use: a living process holds the lock. Errc::no_permission: the message names the
  /// obstacle and its owner.
  static Result<FileLock> take(const std::string& path);

  FileLock(FileLock&&) noexcept = default;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock() { remove(); }

  int descriptor() const { return file_.get(); }
  /// Releases the lock, and keeps the file.
  void unlock() noexcept;
  /// Returns whether the path still names the file that is locked.
  bool is_named() const noexcept;
  /// Unlinks the file, unless the path names another file by now. The file stays locked until this object is
  /// destroyed.
  void remove() noexcept;

 private:
  FileLock(std::string path, Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}
  static Result<FileLock> publish(FileLock lock);

  std::string path_;
  Descriptor file_;
};

/// Returns whether another open file description holds the lock of this file. Takes no lock and never waits.
bool is_locked(int descriptor) noexcept;
/// Returns whether the file at this path is locked; false if there is no file.
bool is_locked_at(const char* path) noexcept;

}  // namespace sft::shm
