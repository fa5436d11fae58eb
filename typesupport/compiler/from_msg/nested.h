// Finds the files of nested types.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Directories of packages. The first directory that has <package>/msg/<Name>.msg or .idl defines the type; a
/// service is defined by <package>/srv/<Name>.srv or .idl.
class SearchPath {
 public:
  explicit SearchPath(std::vector<std::filesystem::path> roots) : roots_(std::move(roots)) {}

  /// Returns the file that defines the type; empty if no directory has such a file.
  std::optional<std::filesystem::path> find(const TypeName& type) const;

  /// Returns the directories as text for error messages.
  std::string text() const;

 private:
  std::vector<std::filesystem::path> roots_;
};

/// Returns the types of the fields of `definition`, each once.
std::vector<TypeName> nested_types(const Definition& definition);

/// Returns the files of all types that `definition` nests, directly or not, each once. The search does not
/// continue inside .idl files and inside .msg files with errors. Types that do not exist, and types that
/// contain themselves, are errors.
tl::expected<std::vector<std::filesystem::path>, std::vector<Problem>> nested_files(
    const Definition& definition, const SearchPath& search_path);

/// Returns the text of a file. Throws std::system_error.
std::string read_file(const std::filesystem::path& path);

}  // namespace sft::msg
