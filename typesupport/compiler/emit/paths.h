// The path by which generated code includes the header of an IDL file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sft::idl {

/// Directories in which headers have the same relative paths as IDL files.
class Roots {
 public:
  /// `list` is separated by colons, and `base_dir` may be null. Without any root, the directory of
  /// `main_file` is one.
  Roots(const char* list, const char* base_dir, const std::filesystem::path& main_file);

  /// The path of `file` relative to the innermost root that contains it. Throws std::runtime_error if no root
  /// does.
  std::filesystem::path relative(const std::filesystem::path& file) const;

 private:
  std::vector<std::filesystem::path> roots_;
};

}  // namespace sft::idl
