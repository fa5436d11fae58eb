// The exit codes of sftd.
#pragma once

namespace sft::shm {

enum class ExitCode : unsigned char {
  /// The daemon is ready, or another daemon was already running; the command `status` or `stop` has
  /// succeeded.
  done = 0,
  no_space = 1,        ///< there is too little space in /dev/shm
  foreign_daemon = 2,  ///< another iceoryx daemon runs
  failed = 3,          ///< any other failure, which the message names
  not_running = 4,     ///< status and stop: no sftd is running
  no_answer = 5,       ///< status and stop: the daemon does not answer, or does not end
  not_permitted = 6,   ///< stop: the daemon belongs to another user
  bad_config = 7,      ///< the configuration file is wrong, or names an object that does not exist
};

inline constexpr const char* exit_codes_help =
    "Exit codes: 0 done, or the daemon is already running; 1 /dev/shm is too small;\n"
    "2 another iceoryx daemon runs; 3 any other failure, with a message; 4 no sftd\n"
    "is running; 5 the daemon does not answer or end; 6 the daemon is another\n"
    "user's; 7 the configuration is wrong.";

}  // namespace sft::shm
