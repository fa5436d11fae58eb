// Emulated hosts. Each has a network namespace with eth0 on the network of the test, and its own /dev/shm and
// /tmp. A host has no name and ends with the test.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tests/pairs/network.h"
#include "tests/support/isolated_host.h"

namespace sft::test {

class Host {
 public:
  /// Makes a host on the network, with an address 10.78.0.x.
  explicit Host(Network& network);
  /// The parts that a container shares with a neighbouring container. The container has its own copy of each
  /// other part. The eth0 of both is on the same network.
  struct Shared {
    bool network = false;
    bool shm = false;  ///< whether /dev/shm is shared
    bool tmp = false;
  };
  Host(const Host& neighbour, const Shared& shared);
  ~Host();
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  /// Has the effect of `ip link set eth0 up` (or down).
  void set_link(bool up) const;
  /// Plugs or unplugs the cable of this host.
  void set_plugged(bool plugged) const { network_->set_plugged(port_, plugged); }

  /// Moves the calling process, which must have one thread, onto this host. Returns false if that fails.
  bool enter() const noexcept;

 private:
  void make(const std::function<void()>& furnish);
  void join_network();

  Network* network_;
  std::size_t port_ = 0;
  int network_namespace_ = -1;
  int mount_namespace_ = -1;
  int control_ = -1;  ///< a socket of that namespace, to set its interfaces
};

/// The account that runs a program, and the directory of the program, which the account must be able to
/// reach.
struct Account {
  uid_t user = 0;  ///< also the number of the account's only group; 0 is the user of the test
  std::string programs = program_directory();
};

/// A program of the project that runs on a host. The destructor kills it.
class Process {
 public:
  /// Starts the program. `input` becomes its standard input.
  Process(const Host& host, const std::string& program, const std::vector<std::string>& arguments,
          int input = -1, const Account& account = {});
  ~Process() { kill_now(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Sends SIGSTOP or SIGCONT.
  void signal(int number) const;
  /// Kills the program by SIGKILL, and waits for its end.
  void kill_now();
  pid_t pid() const { return pid_; }
  /// Waits for the end of the program. Returns its exit code, or minus the signal that ended the program, or
  /// minus SIGALRM if the program does not end.
  int wait_for_end();

 private:
  pid_t pid_ = -1;
};

/// The daemon for the shared memory of a host. The peers of these tests start no daemon themselves.
class Daemon : public Process {
 public:
  explicit Daemon(const Host& host) : Process(host, "sftd", {"--foreground", "--pool-mib=32"}) {}
};

}  // namespace sft::test
