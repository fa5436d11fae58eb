// The files by which a process finds sftd: the host file /dev/shm/sft_host, the lock /tmp/sftd.lock and the
// socket /tmp/roudi.
//
// The host file shows that an sftd serves this /dev/shm. The host file identifies the memory of the daemon
// by a random token. Processes exchange their tokens to learn whether they share memory. The file is locked
// as long as the daemon lives.
//
// The host file is text with one "key value" in each line. The last line is "end"; without it the file is
// incomplete.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/platform/trusted_file.h"
#include "core/seam/transport.h"
#include "shm_transport/host/file_lock.h"

namespace sft::shm {

inline constexpr const char* host_file_path = "/dev/shm/sft_host";
inline constexpr const char* daemon_lock_path = "/tmp/sftd.lock";
inline constexpr const char* roudi_socket_path = "/tmp/roudi";
inline constexpr const char* runtime_name_stem = "sft_";  ///< the names of our sockets in /tmp begin with it

/// The version of the host file, of the messages between programs and sftd, of their data in shared memory,
/// and of the way in which they take chunks and places in queues. The version is raised when an older
/// program or daemon would misunderstand a newer one, or would damage its data (replaced_functions.h).
inline constexpr std::uint32_t host_protocol = 4;
/// The error with which sftd refuses a registration once it serves the maximum number of processes.
inline constexpr const char* too_many_processes = "SFT_PROCESS_LIST_FULL";

/// Returns whether a process may have this name. The name is also the name of the process's socket. So the
/// socket must be in /tmp itself, and the name must not be that of a file of the daemon.
bool is_runtime_name(std::string_view name) noexcept;
/// Returns the end of the names of all processes in this pid namespace, within which process ids are
/// comparable. Empty if the system does not name the namespace.
std::string pid_namespace_mark();

struct HostFile {
  std::array<std::uint8_t, 16> token{};
  pid_t pid = 0;                       ///< pid of the daemon in its own pid namespace; only used in messages
  std::uint32_t protocol = 1;          ///< host_protocol of the daemon; files of version 1 lack it
  std::uint64_t port_pool_offset = 0;  ///< the position of iceoryx's table of ports in the management segment
  std::string segment{};               ///< the name of the segment with the samples, in /dev/shm
  std::uint64_t segment_id = 0;        ///< the segment's number in iceoryx's relative pointers
  std::uint64_t segment_bytes = 0;
  std::optional<gid_t> readers{};  ///< the group that may only read samples, if there is such a group
};

std::string format(const HostFile& file);
std::optional<HostFile> parse_host_file(std::string_view text);

/// An open host file. It shows whether the daemon that wrote it still lives.
class HostMonitor {
 public:
  enum class Finding {
    absent,    ///< there is no file, or the file is not locked
    starting,  ///< the file is locked, but not yet complete
    alive,
    foreign,  ///< the file is ignored: the account that has locked it is not accepted
  };
  struct Look;
  /// Looks for the daemon, and never waits. `accepted` are the accounts whose daemons are accepted.
  static Look look(const core::TrustedAccounts& accepted);

  const HostFile& file() const { return file_; }
  /// Returns the account of the daemon.
  uid_t user() const { return user_; }
  /// Returns whether the daemon that wrote this file lives, even if another daemon has replaced the file
  /// since then. Costs one system call.
  bool daemon_lives() const noexcept { return is_locked(descriptor_.get()); }

 private:
  HostMonitor(Descriptor descriptor, HostFile file, uid_t user)
      : descriptor_(std::move(descriptor)), file_(std::move(file)), user_(user) {}

  Descriptor descriptor_;
  HostFile file_;
  uid_t user_;
};

struct HostMonitor::Look {
  Finding finding = Finding::absent;
  std::optional<HostMonitor> monitor{};  ///< set if `finding` is `alive`
  uid_t user = 0;                        ///< the owner of the file, if `finding` is `foreign`
};

/// The contents of the lock file of a living daemon in /tmp. They show that a daemon runs even if this
/// process cannot see its host file, because the daemon has another /dev/shm.
struct DaemonLock {
  pid_t pid = 0;         ///< pid of the daemon; 0: the daemon has not written it yet
  dev_t shm_device = 0;  ///< the device number of the daemon's /dev/shm, unique while the daemon runs
  uid_t user = 0;        ///< the owner of the file
  /// Returns whether the daemon has started and uses the same /dev/shm as this process.
  bool serves_this_shm() const;
};
std::string format_lock(const DaemonLock& lock);
/// Returns nothing if no process holds the lock.
std::optional<DaemonLock> read_daemon_lock();
/// Returns the message to users if a daemon serves this /dev/shm, but its files there were removed.
std::string names_are_gone(pid_t daemon);

/// Returns the token of the host: the id of this boot and the token of the daemon.
core::HostToken host_token(const HostFile& file);

enum class SocketState { alive, gone, unknown };
/// Returns whether a process listens on this socket; `unknown` if this process lacks the right to query it.
/// The listener does not notice the query.
SocketState socket_state_at(const char* path) noexcept;

}  // namespace sft::shm
