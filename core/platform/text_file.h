// Reads text files that a user names, such as configurations.
#pragma once

#include <string>

#include "sft/result.h"

namespace sft::core {

/// Returns the text of a regular file of at most 1 MiB. The function never waits for a writer of a FIFO, and
/// never reads a device. Returns Errc::unavailable otherwise. The error begins with the path.
Result<std::string> read_text_file(const std::string& path);

}  // namespace sft::core
