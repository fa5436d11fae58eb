// Files as the compiler leaves them: complete, or not there.
#pragma once

#include <filesystem>
#include <string_view>

namespace sft::idl {

/// Replaces `path` in one step: no reader and no interrupted build ever sees a part of it. Throws
/// std::system_error.
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sft::idl
