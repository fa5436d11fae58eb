// The parsed command line of the user.
#pragma once

#include <variant>

#include "tools/sft/bag.h"
#include "tools/sft/bridge.h"
#include "tools/sft/bw.h"
#include "tools/sft/common_options.h"
#include "tools/sft/delay.h"
#include "tools/sft/doctor.h"
#include "tools/sft/echo.h"
#include "tools/sft/exit_code.h"
#include "tools/sft/hz.h"
#include "tools/sft/info.h"
#include "tools/sft/ls.h"
#include "tools/sft/perf.h"
#include "tools/sft/play.h"
#include "tools/sft/pub.h"
#include "tools/sft/record.h"
#include "tools/sft/top.h"
#include "tools/sft/type.h"
#include "tools/sft/why.h"

namespace sft::tool {

/// The options of the chosen subcommand.
using Command = std::variant<LsOptions, InfoOptions, TypeOptions, EchoOptions, PubOptions, HzOptions,
                             BwOptions, DelayOptions, WhyOptions, TopOptions, DoctorOptions, RecordOptions,
                             PlayOptions, BagOptions, BridgeOptions, PerfOptions>;

struct CommandLine {
  std::string name;  ///< the name of the subcommand
  CommonOptions common;
  Command command;
};

/// Parses the command line. Returns an exit code if there is nothing to run, because help was printed or a
/// mistake was reported.
std::variant<CommandLine, ExitCode> parse_command_line(int argc, char** argv);

}  // namespace sft::tool
