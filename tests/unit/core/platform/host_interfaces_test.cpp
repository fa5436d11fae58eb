// The interfaces that the system lists, and what is said if it does not list them.
#include "core/platform/host_interfaces.h"

#include <gmock/gmock.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <net/if.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <iterator>
#include <thread>

namespace sft::core {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

class HostInterfacesTest : public testing::Test {
 protected:
  /// Lists the interfaces while no index can be found the first times, and returns the error; empty: there is
  /// none.
  std::string error_if_fails(int times, int error) {
    finds = 0;
    const auto listed = host_interfaces([&](const char* name) -> unsigned {
      if (++finds > times) return ::if_nametoindex(name);
      errno = error;
      return 0;
    });
    return listed ? "" : listed.error().message;
  }

  int finds = 0;
};

TEST_F(HostInterfacesTest, AreListedWithTheirIndices) {
  const auto listed = host_interfaces().value();
  ASSERT_FALSE(listed.empty());
  for (const HostInterface& one : listed) EXPECT_EQ(one.index, ::if_nametoindex(one.name.c_str()));
}

TEST_F(HostInterfacesTest, AreListedAgainIfOneHasDisappeared) {
  EXPECT_EQ(error_if_fails(1, ENODEV), "");
  EXPECT_EQ(error_if_fails(1'000'000, ENODEV),
            "the system does not list its network interfaces (No such device)")
      << "but not for ever";
}

TEST_F(HostInterfacesTest, NeedADescriptor) {
  const char* const says =
      "(Too many open files): raise the limit RLIMIT_NOFILE (ulimit -n, or LimitNOFILE= of a service)";
  EXPECT_THAT(error_if_fails(1'000'000, EMFILE), EndsWith(says));
  rlimit usual{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &usual), 0);
  const rlimit none{0, usual.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto listed = host_interfaces();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &usual), 0);
  ASSERT_FALSE(listed);
  EXPECT_THAT(listed.error().message, EndsWith(says));
}

/// Makes socket(AF_NETLINK) fail for this thread from now on, as the settings of a service can.
bool forbid_netlink() {
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AF_NETLINK, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EAFNOSUPPORT),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog program{std::size(filter), filter};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &program) == 0;
}

TEST_F(HostInterfacesTest, NeedSocketsOfNetlink) {
  bool is_forbidden = false;
  std::string says;
  std::thread([&] {
    is_forbidden = forbid_netlink();
    const auto listed = host_interfaces();
    says = listed ? "" : listed.error().message;
  }).join();
  if (!is_forbidden) GTEST_SKIP() << "no filter for system calls is allowed here";
  EXPECT_THAT(says, AllOf(HasSubstr("(Address family not supported by protocol)"),
                          HasSubstr("allow sockets of AF_NETLINK")));
}

}  // namespace
}  // namespace sft::core
