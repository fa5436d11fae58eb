// Writes files so that they are either complete or do not exist.
#pragma once

#include <filesystem>
#include <string_view>

namespace sft::idl {

/// Replaces the file at `path` in one step, so that readers and interrupted builds never see an incomplete
/// file. Throws std::system_error.
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sft::idl
