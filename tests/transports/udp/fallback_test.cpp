#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

/// Makes a system call fail from now on, in this thread and the threads that it starts. If `argument` is
/// given, the call fails only with that first argument. `flags` are those of seccomp(2).
void forbid(unsigned call, std::optional<unsigned> argument, int error, unsigned flags = 0) {
  const sock_filter any_argument = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  const sock_filter first_argument = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args));
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 3),
      argument ? first_argument : any_argument,
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, argument.value_or(call), 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<unsigned>(error)),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{std::size(filter), filter};
  ASSERT_EQ(::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0), 0);
  ASSERT_EQ(::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, flags, &program), 0);
}

/// Runs the action on a thread in which that system call fails, with `argument` as for forbid().
void without(unsigned call, std::optional<unsigned> argument, int error,
             const std::function<void()>& action) {
  std::thread([&] {
    forbid(call, argument, error);
    action();
  }).join();
}

/// Runs the action on a thread that cannot use io_uring, as in many containers.
void without_io_uring(int error, const std::function<void()>& action) {
  without(SYS_io_uring_setup, {}, error, action);
}

TEST(Fallback, UsesPlainSocketsWhereIoUringIsForbiddenAndSaysWhy) {
  without_io_uring(EPERM, [] {
    const auto transport = open_udp_transport({}, test::make_pool()).value();
    EXPECT_NE(transport->description().find("plain sockets"), std::string::npos);
    EXPECT_NE(transport->description().find("seccomp"), std::string::npos) << transport->description();
    EXPECT_EQ(transport->poll({}), core::Availability::ready);
  });
}

std::string why_not(const core::Network& network, const std::string& name) {
  NodeStatus status;
  network.add_to(status);
  const auto found = std::ranges::find(status.quick_paths, name, &NodeStatus::QuickPath::name);
  return found == status.quick_paths.end() ? "not told" : found->why_not;
}

TEST(Fallback, NamesTheReasonForWhichIoUringIsNotUsed) {
  const auto reason_for = [](int error) {
    std::string reason;
    without_io_uring(
        error, [&] { reason = why_not(*open_udp_transport({}, test::make_pool()).value(), "io_uring"); });
    return reason;
  };
  EXPECT_TRUE(reason_for(EPERM).starts_with("it is forbidden here (")) << reason_for(EPERM);
  EXPECT_EQ(reason_for(ENOSYS), "the kernel has none");
  EXPECT_EQ(reason_for(EINVAL), "the kernel is older than 6.1");
  EXPECT_EQ(reason_for(ENOMEM), "too little memory may be locked (ulimit -l)");
}

TEST(Fallback, NamesTheReasonForWhichDatagramsLeaveOneByOne) {
  without(SYS_getsockopt, {}, ENOPROTOOPT, [] {
    const auto transport = open_udp_transport({}, test::make_pool()).value();
    EXPECT_EQ(why_not(*transport, "GSO"), "the system refuses it: Protocol not available");
  });
}

TEST(Fallback, IsNotTakenWhereTheKernelGrantsIoUring) {
  if (const std::string why = test::refusal_of(Backend::io_uring); !why.empty()) GTEST_SKIP() << why;
  const auto transport = open_udp_transport({}, test::make_pool()).value();
  EXPECT_TRUE(transport->description().starts_with("io_uring with ")) << transport->description();
}

TEST(Fallback, UsesPlainSocketsForEveryOtherRefusal) {
  for (const int error : {ENOSYS, ENOMEM, EINVAL, EMFILE}) {
    without_io_uring(error, [] {
      EXPECT_NE(open_udp_transport({}, test::make_pool()).value()->description().find("plain sockets"),
                std::string::npos);
    });
  }
}

/// Forbids io_uring while a transport is open, and expects that the transport then uses plain sockets. Some
/// programs forbid themselves system calls after they have opened their files and sockets.
void expect_plain_sockets_after(int error) {
  const auto here = open_udp_transport({}, test::make_pool()).value();
  const auto there = open_udp_transport({}, test::make_pool()).value();
  test::Subscriber subscriber(*here, {"*"});
  test::Publisher publisher(*there);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{test::loopback_address(*here), "*", true}});
  publisher.publish(test::make_image(10));
  EXPECT_EQ(subscriber.await_new(1).size(), 1U);
  EXPECT_EQ(why_not(*here, "io_uring"), "");
  forbid(SYS_io_uring_enter, {}, error, SECCOMP_FILTER_FLAG_TSYNC);
  for (int i = 0; i < 10; ++i) {
    publisher.publish(test::make_image(300'000));
    EXPECT_EQ(subscriber.await_new(1).size(), 1U) << i;
  }
  EXPECT_EQ(here->poll({}), core::Availability::ready);
  // The receiving thread may still sleep in a call that began before io_uring was forbidden.
  EXPECT_TRUE(eventually([&] { return here->description().find("plain sockets") != std::string::npos; }));
  EXPECT_TRUE(why_not(*here, "io_uring").starts_with("it was forbidden while it was in use"));
}

TEST(Fallback, ReceivesByPlainSocketsOnceIoUringIsForbiddenToARunningProgram) {
  if (const std::string why = test::refusal_of(Backend::io_uring); !why.empty()) GTEST_SKIP() << why;
  for (const int error : {EPERM, ENOSYS, EACCES}) {
    const pid_t child = ::fork();  // a process of its own, because the restriction is permanent
    if (child == 0) {
      expect_plain_sockets_after(error);
      std::fflush(stdout);
      std::_Exit(testing::Test::HasFailure() ? 1 : 0);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << "errno " << error;
  }
}

TEST(Fallback, DoesNotReplaceIoUringWhereItIsDemanded) {
  without_io_uring(EPERM, [] {
    const auto transport = open_udp_transport({.backend = Backend::io_uring}, test::make_pool());
    ASSERT_FALSE(transport);
    EXPECT_EQ(transport.error().code, Errc::no_permission);
  });
}

/// A kernel that was started with ipv6.disable=1 fails in the same way.
TEST(Fallback, UsesIPv4AloneWhereTheSystemHasNoIPv6) {
  without(SYS_socket, AF_INET6, EAFNOSUPPORT, [] {
    const auto there = open_udp_transport({}, test::make_pool()).value();
    const auto here = open_udp_transport({}, test::make_pool()).value();
    EXPECT_NE(here->description().find("IPv4 only"), std::string::npos) << here->description();
    for (const core::UdpAddress& address : here->addresses()) EXPECT_TRUE(address.ip.is_ipv4());
    test::Subscriber subscriber(*here, {"*"});
    test::Publisher publisher(*there);
    subscriber.listen_reliably_to(publisher.id());
    publisher.serve({{test::loopback_address(*here), "*", true}});
    publisher.publish(test::make_image(300'000));
    EXPECT_EQ(subscriber.await(1).size(), 1U);
    EXPECT_FALSE(open_udp_transport({.bind_address = core::loopback_ipv6}, test::make_pool()));
  });
}

}  // namespace
}  // namespace sft::udp
