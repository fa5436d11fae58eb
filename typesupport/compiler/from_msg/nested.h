// The files of nested types.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Directories of packages. A type is defined by the first of them that has <package>/msg/<Name>.msg, or
/// .idl.
class SearchPath {
 public:
  explicit SearchPath(std::vector<std::filesystem::path> roots) : roots_(std::move(roots)) {}

  /// Empty: there is none.
  std::optional<std::filesystem::path> find(const TypeName& type) const;

  /// For messages.
  std::string text() const;

 private:
  std::vector<std::filesystem::path> roots_;
};

/// The types that `definition` nests itself, each once.
std::vector<TypeName> nested_types(const Definition& definition);

/// The files of all types that `definition` nests, directly or not, each once; of those that are not read
/// because they are .idl or have problems of their own only they. Problems are types that do not exist and
/// types that contain themselves. Reads files.
tl::expected<std::vector<std::filesystem::path>, std::vector<Problem>> nested_files(
    const Definition& definition, const SearchPath& search_path);

/// The text of a file. Throws std::system_error.
std::string read_file(const std::filesystem::path& path);

}  // namespace sft::msg
