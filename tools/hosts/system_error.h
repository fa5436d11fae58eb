// Converts failed system calls to errors of the library.
#pragma once

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "sft/result.h"

namespace sft::hosts {

/// Returns the error of the system call that has just failed. The error begins with `what`, which names the
/// action that failed.
inline tl::unexpected<Error> system_error(std::string_view what) {
  const Errc code = errno == EPERM || errno == EACCES ? Errc::no_permission : Errc::system;
  return fail(code, fmt::format("{}: {}", what, std::strerror(errno)));
}

inline Result<void> checked(bool done, std::string_view what) {
  if (done) return {};
  return system_error(what);
}

}  // namespace sft::hosts
