// What the command sft says to the shell that started it.
#pragma once

namespace sft::tool {

enum class ExitCode : int {
  done = 0,     ///< of doctor: all is well
  nothing = 1,  ///< what was asked for is not there, or did not come in time; of doctor: a warning
  failed = 2,   ///< wrong usage, or something failed; of doctor: an error
};

inline constexpr const char* exit_codes_help =
    "Exit codes: 0 done; 1 what was asked for is not there, or did not come in time;\n"
    "2 wrong usage, or something failed. Of why: 1 also if a pair does not match.\n"
    "Of doctor: 0 all is well; 1 a warning; 2 an error. Ctrl-C is the regular end of\n"
    "what runs on: 0 if anything had come, else 1.";

}  // namespace sft::tool
