// The exit codes of the command sft.
#pragma once

namespace sft::tool {

enum class ExitCode : int {
  done = 0,     ///< for doctor: there is no fault
  nothing = 1,  ///< the requested topic or sample was not found in time; for doctor: a warning
  failed = 2,   ///< wrong usage, or a failure; for doctor: an error
  unmet = 3,    ///< a condition of `sft perf --fail-if` holds
};

inline constexpr const char* exit_codes_help =
    "Exit codes: 0 done; 1 what you asked for is not there, or did not come in time;\n"
    "2 wrong usage, or something failed. For why: 1 also if a pair does not match.\n"
    "For doctor: 0 all is well; 1 a warning; 2 an error. Ctrl-C is the regular end of\n"
    "commands that run on: 0 if any sample has come, else 1. For perf: 3 if\n"
    "a condition of --fail-if holds.";

}  // namespace sft::tool
