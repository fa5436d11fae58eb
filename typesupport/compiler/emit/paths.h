// The path with which generated code includes the header of an IDL file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sft::idl {

/// The directories below which headers have the same relative paths as IDL files.
class Roots {
 public:
  /// `list` is separated by colons, and `base_dir` may be null. If neither of them has a root, the
  /// directory of `main_file` is the root.
  Roots(const char* list, const char* base_dir, const std::filesystem::path& main_file);

  /// Returns the path of `file` relative to the innermost root that contains it. Throws std::runtime_error
  /// if no root contains the file.
  std::filesystem::path relative(const std::filesystem::path& file) const;

 private:
  std::vector<std::filesystem::path> roots_;
};

}  // namespace sft::idl
