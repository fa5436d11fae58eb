#include <signal.h>
#include <stdlib.h>

#include "tools/sft/command_line.h"
#include "tools/sft/output.h"
#include "tools/sft/session.h"
#include "tools/terminal/stop.h"

namespace {

using namespace sft::tool;

ExitCode run(const CommandLine& line, Stop& stop, Output& output) {
  if (const auto* doctor = std::get_if<DoctorOptions>(&line.command))
    return run(*doctor, line.common, stop, output);
  if (const auto* bag = std::get_if<BagOptions>(&line.command)) return run(*bag, line.common, stop, output);
  if (const auto* bridge = std::get_if<BridgeOptions>(&line.command))
    return run(*bridge, line.common, stop, output);
  sft::Result<Session> session = Session::open(line.common, line.name, stop, output);
  if (!session) {
    complain(session.error().message);
    return ExitCode::failed;
  }
  return std::visit(
      [&](const auto& options) {
        using Options = std::decay_t<decltype(options)>;
        if constexpr (std::is_same_v<Options, DoctorOptions> || std::is_same_v<Options, BagOptions> ||
                      std::is_same_v<Options, BridgeOptions>) {
          return ExitCode::done;  // these commands have been run above
        } else {
          return run(options, line.common, *session);
        }
      },
      line.command);
}

}  // namespace

int main(int argc, char** argv) {
  const auto parsed = parse_command_line(argc, argv);
  if (const auto* code = std::get_if<ExitCode>(&parsed)) return static_cast<int>(*code);
  const auto& line = std::get<CommandLine>(parsed);
  // SFT_REMAP is meant for programs. The tool shows the names of topics as they are announced.
  unsetenv("SFT_REMAP");
  signal(SIGPIPE, SIG_IGN);  // Output detects a closed pipe when it writes
  Stop stop;
  Output output(stop, line.common.no_color);
  const ExitCode code = run(line, stop, output);
  if (output.failure().empty()) return static_cast<int>(code);
  complain("the output cannot be written: " + output.failure());
  return static_cast<int>(ExitCode::failed);
}
