#include "tests/pairs/host.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <grp.h>
#include <net/if.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "tests/support/eventually.h"
#include "tools/hosts/own_host.h"

namespace sft::test {

namespace {

constexpr std::uint32_t first_address = 0x0A4E0001;  // the address 10.78.0.1
constexpr std::uint32_t netmask = 0xFFFFFF00;

int checked(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

ifreq request_for(const char* interface) {
  ifreq request{};
  std::strcpy(request.ifr_name, interface);
  return request;
}

void set_up(int control, const char* interface, bool up) {
  ifreq request = request_for(interface);
  checked(ioctl(control, SIOCGIFFLAGS, &request), interface);
  const int flags = up ? request.ifr_flags | IFF_UP | IFF_MULTICAST : request.ifr_flags & ~IFF_UP;
  request.ifr_flags = static_cast<short>(flags);
  checked(ioctl(control, SIOCSIFFLAGS, &request), interface);
}

void set_address(int control, unsigned long what, std::uint32_t ipv4) {
  ifreq request = request_for("eth0");
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(ipv4);
  std::memcpy(&request.ifr_addr, &address, sizeof address);
  checked(ioctl(control, what, &request), "the address of eth0");
}

/// Changes to that user, whose only group has the same number. Returns false if that fails. For user 0
/// nothing changes.
bool become(uid_t user) noexcept {
  return user == 0 || (setgroups(0, nullptr) == 0 && setgid(user) == 0 && setuid(user) == 0);
}

void mounted(const Result<void>& done) {
  if (!done) throw std::runtime_error(done.error().message);
}

}  // namespace

Host::Host(Network& network) : network_(&network) {
  make([this] {
    join_network();
    mounted(mount_own_memory());
  });
}

Host::Host(const Host& neighbour, const Shared& shared) : network_(neighbour.network_) {
  make([&] {
    if (shared.network) {
      checked(setns(neighbour.network_namespace_, CLONE_NEWNET), "setns");
      port_ = neighbour.port_;
      control_ = checked(fcntl(neighbour.control_, F_DUPFD_CLOEXEC, 0), "dup");
    } else {
      join_network();
    }
    checked(setns(neighbour.mount_namespace_, CLONE_NEWNS), "setns");
    // Makes a copy of the mounts, so that the neighbour's mounts stay unchanged.
    checked(unshare(CLONE_NEWNS), "unshare");
    if (!shared.shm) mounted(mount_own_shm());
    if (!shared.tmp) mounted(hosts::mount_own_tmp());
  });
}

/// Calls `furnish` on a thread in new namespaces. The object's descriptors keep these namespaces after the
/// thread has ended.
void Host::make(const std::function<void()>& furnish) {
  std::exception_ptr failure;
  std::thread([&] {
    try {
      checked(unshare(CLONE_NEWNS), "unshare");
      furnish();
      network_namespace_ = checked(open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC), "ns/net");
      mount_namespace_ = checked(open("/proc/thread-self/ns/mnt", O_RDONLY | O_CLOEXEC), "ns/mnt");
    } catch (...) {
      failure = std::current_exception();
    }
  }).join();
  if (failure) std::rethrow_exception(failure);
}

/// Moves the calling thread into a new network namespace, and connects it with the network.
void Host::join_network() {
  checked(unshare(CLONE_NEWNET), "unshare");
  control_ = checked(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), "socket");
  port_ = network_->plug_in();
  set_up(control_, "lo", true);
  set_address(control_, SIOCSIFADDR, first_address + static_cast<std::uint32_t>(port_));
  set_address(control_, SIOCSIFNETMASK, netmask);
  set_up(control_, "eth0", true);
}

Host::~Host() {
  for (const int descriptor : {control_, network_namespace_, mount_namespace_}) close(descriptor);
}

void Host::set_link(bool up) const { set_up(control_, "eth0", up); }

bool Host::enter() const noexcept {
  return setns(network_namespace_, CLONE_NEWNET) == 0 && setns(mount_namespace_, CLONE_NEWNS) == 0;
}

/// Between fork() and exec the child calls only functions that are safe although other threads of this
/// process may hold locks.
Process::Process(const Host& host, const std::string& program, const std::vector<std::string>& arguments,
                 int input, const Account& account) {
  const std::string path = account.programs + "/" + program;
  std::vector<char*> words{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  pid_ = fork();
  if (pid_ != 0) return;
  if (input >= 0) dup2(input, STDIN_FILENO);
  const bool ready = host.enter() && become(account.user);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // after become(), because become() would reset this signal
  if (ready) execv(words[0], words.data());
  _exit(127);
}

void Process::signal(int number) const {
  if (pid_ > 0) kill(pid_, number);
}

void Process::kill_now() {
  if (pid_ <= 0) return;
  kill(pid_, SIGKILL);
  waitpid(std::exchange(pid_, -1), nullptr, 0);
}

int Process::wait_for_end() {
  int status = 0;
  if (!eventually([&] { return waitpid(pid_, &status, WNOHANG) == pid_; })) return -SIGALRM;
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace sft::test
