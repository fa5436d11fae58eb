// The error of files that cannot be written.
#pragma once

#include <cerrno>
#include <string>
#include <system_error>

#include "sft/result.h"

namespace sft::tool {

/// Returns the error, with the reason that the system gave last.
inline Error cannot_be_written(const std::string& file) {
  return {Errc::system, "'" + file + "' cannot be written: " + std::generic_category().message(errno)};
}

}  // namespace sft::tool
