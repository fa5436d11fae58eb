// Where the header of an IDL file is included from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "emit.h"

namespace sft::idl {

/// Directories below which headers mirror IDL files.
class Roots {
 public:
  /// `main_file` gives the root that is used where the caller named none: its directory.
  Roots(const sft_output& output, const std::filesystem::path& main_file);

  /// Path of `file` below the innermost root that it is below of. Throws std::runtime_error if there is none.
  std::filesystem::path relative(const std::filesystem::path& file) const;

 private:
  std::vector<std::filesystem::path> roots_;
};

}  // namespace sft::idl
