// An exclusive lock on a file, held as long as its holder lives: how one sftd knows of another, and how nodes
// notice that theirs is gone.
//
// It is an open-file-description lock of fcntl. Unlike flock it can be asked about without being taken, so
// that looking never gets in the way of a daemon that starts; unlike a POSIX lock it is not lost by closing
// some other descriptor.
//
// A holder has locked its file for writing. Locks for reading say nothing: everybody who may read the file
// can have one, of a dead holder's file, too.
#pragma once

#include <string>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::shm {

using Descriptor = core::FileDescriptor;

class FileLock {
 public:
  /// A new, empty file at `path`, locked. One that a dead process left there is replaced, never reused:
  /// whoever still has it open must not take this holder for the former one. So is whatever else is there,
  /// where this account may remove it. Errc::address_in_use if a living process holds the lock;
  /// Errc::no_permission names what is in the way, and whose it is.
  static Result<FileLock> take(const std::string& path);

  FileLock(FileLock&&) noexcept = default;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock() { remove(); }

  int descriptor() const { return file_.get(); }
  /// Whoever looks finds that nobody holds the lock.
  void unlock() noexcept;
  /// Whether the path still names the file that is locked.
  bool is_named() const noexcept;
  /// Unlinks the file, unless the path names another one by now. It stays locked until this object goes.
  void remove() noexcept;

 private:
  FileLock(std::string path, Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}
  static Result<FileLock> publish(FileLock lock);

  std::string path_;
  Descriptor file_;
};

/// Whether another open file description holds the lock of this file. Takes nothing, never waits.
bool is_locked(int descriptor) noexcept;
/// The same of the file that is there now; false if there is none.
bool is_locked_at(const char* path) noexcept;

}  // namespace sft::shm
