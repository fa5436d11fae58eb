// How a node uses shared memory and its daemon.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "core/platform/thread.h"

namespace sft::shm {

struct ShmOptions {
  std::string daemon_path{};  ///< of sftd; empty: as daemon_search.h says
  /// Who says so, for people.
  std::string daemon_named_by = "NodeOptions::shm.daemon_path";
  bool start_daemon = true;                  ///< when none runs
  std::chrono::seconds daemon_idle_exit{0};  ///< one started so ends without clients for so long; 0: never

  /// Accounts, by name or number, whose daemon is used besides that of root, of this account, and of the
  /// owner of /run/sft (accepted_daemons.h). What one node of a process accepts holds for all of them.
  std::vector<std::string> daemon_users{};

  /// Of this process's name with the daemon, for people who look there.
  std::string runtime_name_prefix = "node";

  std::chrono::milliseconds start_deadline{20'000};   ///< for a daemon to become ready
  std::chrono::milliseconds connect_deadline{1'000};  ///< for it to take this process on
  std::chrono::milliseconds port_deadline{500};       ///< for it to make a port

  core::ThreadSpec wake_thread = "sft-wake";  ///< wakes readers where several sleep

  std::uint32_t queue_limit = 256;  ///< samples waiting, per reader and writer; at most 256
  std::uint32_t held_limit = 256;   ///< samples held, per writer and per reader and writer; at most 256
};

}  // namespace sft::shm
