#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <thread>

#include "endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

/// Runs the action on a thread whose io_uring_setup() fails, as containers make it.
void without_io_uring(int error, const std::function<void()>& action) {
  std::thread([&] {
    sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_io_uring_setup, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<unsigned>(error)),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog program{std::size(filter), filter};
    ASSERT_EQ(::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
    ASSERT_EQ(::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program), 0);
    action();
  }).join();
}

TEST(Fallback, UsesPlainSocketsWhereIoUringIsForbiddenAndSaysWhy) {
  without_io_uring(EPERM, [] {
    const auto transport = open_udp_transport({}, test::make_pool()).value();
    EXPECT_NE(transport->description().find("plain sockets"), std::string::npos);
    EXPECT_NE(transport->description().find("seccomp"), std::string::npos) << transport->description();
    EXPECT_EQ(transport->poll({}), core::Availability::ready);
  });
}

TEST(Fallback, UsesPlainSocketsForEveryOtherRefusal) {
  for (const int error : {ENOSYS, ENOMEM, EINVAL, EMFILE}) {
    without_io_uring(error, [] {
      EXPECT_NE(open_udp_transport({}, test::make_pool()).value()->description().find("plain sockets"),
                std::string::npos);
    });
  }
}

TEST(Fallback, DoesNotReplaceIoUringWhereItIsDemanded) {
  without_io_uring(EPERM, [] {
    const auto transport = open_udp_transport({.backend = Backend::io_uring}, test::make_pool());
    ASSERT_FALSE(transport);
    EXPECT_EQ(transport.error().code, Errc::no_permission);
  });
}

}  // namespace
}  // namespace sft::udp
