// An exclusive lock on a file, held as long as its holder lives: how one sftd knows of another, and how nodes
// notice that theirs is gone.
//
// It is an open-file-description lock of fcntl. Unlike flock it can be asked about without being taken, so
// that looking never gets in the way of a daemon that starts; unlike a POSIX lock it is not lost by closing
// some other descriptor.
#pragma once

#include <string>
#include <utility>

#include "sft/typesupport/result.h"

namespace sft::shm {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor();

  explicit operator bool() const { return fd_ >= 0; }
  int get() const { return fd_; }

 private:
  int fd_ = -1;
};

class FileLock {
 public:
  /// A new, empty file at `path`, locked. One that a dead process left there is replaced, never reused:
  /// whoever still has it open must not take this holder for the former one. Errc::address_in_use if a living
  /// process holds it.
  static Result<FileLock> take(const std::string& path);

  FileLock(FileLock&&) noexcept = default;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock() { remove(); }

  int descriptor() const { return file_.get(); }
  /// Unlinks the file, which stays locked until this object goes.
  void remove() noexcept;

 private:
  FileLock(std::string path, Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  Descriptor file_;
};

/// Whether another open file description holds the lock of this file. Takes nothing.
bool is_locked(int descriptor) noexcept;

}  // namespace sft::shm
