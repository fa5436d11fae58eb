// Both backends, and the only reason for which a test may omit one of them.
#pragma once

#include <gtest/gtest.h>
#include <linux/io_uring.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "udp_transport/udp_transport.h"

namespace sft::udp::test {

/// Returns the reason why the system offers no io_uring, or "" if io_uring can be used. Asks the system
/// itself, independently of the tested code. Always returns "" for plain sockets, because a test must fail if
/// they cannot be opened.
inline std::string refusal_of(Backend backend) {
  if (backend != Backend::io_uring) return {};
  io_uring_params params{};
  params.flags = IORING_SETUP_SINGLE_ISSUER | IORING_SETUP_DEFER_TASKRUN;
  const long ring = ::syscall(SYS_io_uring_setup, 1, &params);
  if (ring < 0) return std::string("io_uring is refused here: ") + std::strerror(errno);
  ::close(static_cast<int>(ring));
  return {};
}

inline const auto both_backends = testing::Values(Backend::io_uring, Backend::sockets);

/// Returns the name of the backend, as GoogleTest's name for the parameter.
inline constexpr auto backend_name = [](const auto& info) {
  const Backend backend = info.param;
  return std::string(backend == Backend::io_uring ? "IoUring" : "Sockets");
};

}  // namespace sft::udp::test
