// What sftd says to the shell that started it.
#pragma once

namespace sft::shm {

enum class ExitCode : unsigned char {
  done = 0,            ///< ready, or another one already was; of status and stop: done
  no_space = 1,        ///< too little in /dev/shm
  foreign_daemon = 2,  ///< another iceoryx daemon runs
  failed = 3,          ///< anything else, told in the message
  not_running = 4,     ///< of status and stop: there is no sftd here
  no_answer = 5,       ///< of status and stop: it does not answer, or does not end
  not_permitted = 6,   ///< of stop: it is another user's
  bad_config = 7,      ///< the configuration file is wrong, or names what does not exist
};

inline constexpr const char* exit_codes_help =
    "Exit codes: 0 done, or already running; 1 too little /dev/shm; 2 another iceoryx daemon runs; 3 other "
    "failures;\n"
    "4 no sftd is running; 5 it does not answer or end; 6 it is another user's; 7 wrong configuration.";

}  // namespace sft::shm
