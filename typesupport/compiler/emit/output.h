// Writes files that are either complete or do not exist.
#pragma once

#include <filesystem>
#include <string_view>

namespace sft::idl {

/// Replaces `path` in one step, so that readers and interrupted builds never see a part of it. Throws
/// std::system_error.
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sft::idl
