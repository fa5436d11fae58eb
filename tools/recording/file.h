// A file from which bytes are read at any offset.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sft/result.h"
#include "tools/recording/bytes.h"

namespace sft::recording {

class File {
 public:
  /// Opens the file. Returns Errc::unavailable if there is no such file. All errors name the file.
  static Result<File> open(const std::string& path);
  /// Takes over an open descriptor. Errors call the file `name`.
  File(int descriptor, std::uint64_t size, std::string name)
      : descriptor_(descriptor), size_(size), name_(std::move(name)) {}
  File(File&& other) noexcept;
  File& operator=(File&&) = delete;
  ~File();

  std::uint64_t size() const { return size_; }
  const std::string& name() const { return name_; }

  /// Returns these bytes, which are valid until the next call. There are fewer bytes at the end of the
  /// file, or if the system refuses to read.
  std::span<const std::byte> look(std::uint64_t offset, std::size_t length);
  /// Returns a copy of these bytes. The error says why the system refuses to read.
  Result<Bytes> read(std::uint64_t offset, std::uint64_t length) const;

 private:
  int descriptor_;
  std::uint64_t size_;
  std::string name_;
  Bytes window_{};
  std::uint64_t window_at_ = 0;
};

}  // namespace sft::recording
