// Both backends, and the one reason for which a test may leave one of them out.
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

/// Returns why the system gives us no io_uring; empty if it does. Asks the system itself, whatever the
/// tested code concludes. Always empty for plain sockets: if these cannot be opened, a test fails.
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

/// Names the parameter for GoogleTest.
inline constexpr auto backend_name = [](const auto& info) {
  const Backend backend = info.param;
  return std::string(backend == Backend::io_uring ? "IoUring" : "Sockets");
};

}  // namespace sft::udp::test
