// The options of a node for shared memory and its daemon.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/platform/thread.h"
#include "sft/options.h"

namespace sft::shm {

struct ShmOptions {
  std::string daemon_path{};  ///< the file of sftd; empty: it is searched for (daemon_search.h)
  /// The name of the option or variable that set daemon_path, for error messages.
  std::string daemon_named_by = "NodeOptions::shm.daemon_path";
  bool start_daemon = true;  ///< true if sftd is started if none runs
  /// The time without clients after which an sftd that this node starts ends; 0: never.
  std::chrono::seconds daemon_idle_exit = ShmSettings{}.daemon_idle_exit;

  /// Accounts, by name or number, whose daemon is accepted. The daemons of root, of this account, and of
  /// the owner of /run/sft are always accepted (accepted_daemons.h). If one node of a process accepts a
  /// daemon, all nodes of the process use it.
  std::vector<std::string> daemon_users{};

  /// The beginning of the name under which this process registers. `sftd status` shows the name.
  std::string runtime_name_prefix = "node";

  std::chrono::milliseconds start_deadline{20'000};  ///< limit of the time until a daemon is ready
  /// Limit of the time until the daemon has registered this process.
  std::chrono::milliseconds connect_deadline{1'000};
  std::chrono::milliseconds port_deadline{500};  ///< limit of the time until the daemon has made a port
  /// The longest time for which a call that needs a port waits for the daemon, which usually answers within
  /// 0.2 ms. If the daemon answers later than `port_wait`, a later call gets the port.
  std::chrono::milliseconds port_wait{20};

  core::ThreadSpec wake_thread = "sft-wake";  ///< the thread that wakes readers if several sleep

  static constexpr std::uint32_t samples_max = SubscriberOptions::max_held_most;
  /// The maximum number of samples that wait in the queue between one writer and one reader.
  std::uint32_t queue_limit = samples_max;
  /// The maximum number of samples that are held at a time: by each writer, and by each reader of each
  /// writer.
  std::uint32_t held_limit = samples_max;
};

}  // namespace sft::shm
