// /dev/shm/sft_host: the sign that this /dev/shm is served by an sftd. It names the daemon's memory by a
// random token, which processes exchange to learn that they share it, and it is locked as long as that daemon
// lives.
//
// Text, one "key value" a line; incomplete without the last line, "end".
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
inline constexpr const char* runtime_name_stem = "sft_";  ///< of the sockets in /tmp that are ours

/// Of what is said here, of the way programs speak with sftd, and of what they say in shared memory. Counts
/// up when an older program or daemon would misunderstand.
inline constexpr std::uint32_t host_protocol = 3;
/// What a registration is answered with, as an error, that is one too many.
inline constexpr const char* too_many_processes = "SFT_PROCESS_LIST_FULL";

/// Whether a process may be known by this name: its socket is then in /tmp itself, and no file of the
/// daemon's.
bool is_runtime_name(std::string_view name) noexcept;

struct HostFile {
  std::array<std::uint8_t, 16> token{};
  pid_t pid = 0;                       ///< of the daemon in its own pid namespace: for messages only
  std::uint32_t protocol = 1;          ///< the first one did not say
  std::uint64_t port_pool_offset = 0;  ///< of iceoryx's table of ports, in the management segment
  std::string segment{};               ///< name of the segment with the samples, in /dev/shm
  std::uint64_t segment_id = 0;        ///< in iceoryx's relative pointers
  std::uint64_t segment_bytes = 0;
  std::optional<gid_t> readers{};  ///< the group that only reads samples, where there is one
};

std::string format(const HostFile& file);
std::optional<HostFile> parse_host_file(std::string_view text);

/// An open host file. Alive as long as the daemon that wrote it.
class HostWatch {
 public:
  enum class Finding {
    absent,
    starting,
    alive,
    foreign,  ///< of an account that is not accepted: alive, but not to be believed
  };
  struct Look;
  /// Never waits. `accepted`: whose daemon may be one.
  static Look look(const core::TrustedAccounts& accepted);

  const HostFile& file() const { return file_; }
  /// The daemon's account.
  uid_t user() const { return user_; }
  /// One system call, right even if another daemon has replaced the file meanwhile.
  bool daemon_lives() const noexcept { return is_locked(descriptor_.get()); }

 private:
  HostWatch(Descriptor descriptor, HostFile file, uid_t user)
      : descriptor_(std::move(descriptor)), file_(std::move(file)), user_(user) {}

  Descriptor descriptor_;
  HostFile file_;
  uid_t user_;
};

struct HostWatch::Look {
  Finding finding = Finding::absent;
  std::optional<HostWatch> watch{};  ///< where it is alive
  uid_t user = 0;                    ///< where it is foreign: whose it is
};

/// What a living daemon's lock in /tmp says, also where its sign in /dev/shm cannot be seen.
struct DaemonLock {
  pid_t pid = 0;         ///< 0: it has not said yet
  dev_t shm_device = 0;  ///< the number of its /dev/shm, which no other one has meanwhile
  uid_t user = 0;        ///< whose it is
  /// Whether the daemon has begun, and with this process's /dev/shm.
  bool serves_this_shm() const;
};
std::string format_lock(const DaemonLock& lock);
/// Nothing where nobody holds the lock.
std::optional<DaemonLock> read_daemon_lock();
/// What to say where its sign and its memory were removed from the same /dev/shm.
std::string names_are_gone(pid_t daemon);

/// boot_id and the daemon's token.
core::HostToken host_token(const HostFile& file);

enum class Listener { alive, gone, unknown };
/// Whether a process listens on this socket; unknown where this one may not ask. Leaves no trace there.
Listener listener_at(const char* path) noexcept;

}  // namespace sft::shm
