#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "shm_transport/iceoryx.h"
#include "shm_transport/sftd/daemon.h"

namespace {

using namespace sft::shm;

struct Arguments {
  std::size_t pool_mib = 0;
  long idle_exit_s = 0;
  bool foreground = false;
  bool renewed = false;
  LogLevel log_level = LogLevel::warning;
  std::string log_level_name = "warning";
};

const std::map<std::string, LogLevel> log_levels{{"error", LogLevel::error},
                                                 {"warning", LogLevel::warning},
                                                 {"info", LogLevel::info},
                                                 {"debug", LogLevel::debug}};

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("--pool-mib", arguments.pool_mib,
                 "Shared memory for samples, in MiB (default: half of what is free, "
                 "at most 320)")
      ->check(CLI::Range(4, 1 << 20));
  app.add_option("--idle-exit", arguments.idle_exit_s,
                 "Exit after being without clients for so many seconds; 0: never")
      ->check(CLI::Range(0, 1 << 30));
  app.add_flag("--foreground", arguments.foreground,
               "Stay in the terminal, and log to it instead of to syslog");
  app.add_option("--log-level", arguments.log_level_name, "error, warning, info or debug")
      ->check(CLI::IsMember(log_levels));
  app.add_flag("--renewed", arguments.renewed)->group("");  // how it starts itself afresh: detached already
}

/// iceoryx writes to the standard streams, whatever its log level; that is of use only to debug it.
void set_up_iceoryx_output(LogLevel level) {
  const bool wanted = level == LogLevel::debug;
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(
      wanted ? iox::log::LogLevel::kDebug : iox::log::LogLevel::kOff,
      iox::log::LogLevelOutput::kHideLogLevel);
  if (wanted) return;
  for (std::ostream* stream : {&std::cout, &std::cerr, &std::clog}) stream->rdbuf(nullptr);
}

void block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) sigaddset(&signals, signal);
  sigprocmask(SIG_BLOCK, &signals, nullptr);
}

/// The same program again in the same process, with the same settings and nothing else left over.
[[noreturn]] void start_again(const Arguments& arguments) {
  std::vector<std::string> words{"sftd", "--idle-exit=" + std::to_string(arguments.idle_exit_s),
                                 "--log-level=" + arguments.log_level_name,
                                 arguments.foreground ? "--foreground" : "--renewed"};
  if (arguments.pool_mib != 0) words.push_back("--pool-mib=" + std::to_string(arguments.pool_mib));
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv("/proc/self/exe", pointers.data());
  _exit(static_cast<int>(ExitCode::failed));
}

int run(const Arguments& arguments, Starter starter) {
  const bool has_terminal = arguments.foreground;
  const Log log(arguments.log_level, has_terminal ? Log::Target::standard_error : Log::Target::system_log);
  set_up_iceoryx_output(arguments.log_level);
  block_signals();

  DaemonSettings settings;
  if (arguments.pool_mib != 0) settings.pool_bytes = arguments.pool_mib << 20;
  settings.idle_exit = std::chrono::seconds(arguments.idle_exit_s);
  auto daemon = Daemon::start(settings, log);
  if (!daemon) {
    starter.tell(daemon.error().code, daemon.error().message);
    return static_cast<int>(daemon.error().code);
  }
  starter.tell(ExitCode::running, has_terminal ? "ready" : "");
  const Daemon::End end = (*daemon)->serve();
  (*daemon)->remove_traces();
  // Nothing is destroyed: programs may be in the middle of using the ports in shared memory, and iceoryx
  // would take them apart under their hands.
  if (end == Daemon::End::renew) start_again(arguments);
  _exit(static_cast<int>(ExitCode::running));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Hosts the shared memory of SFT's programs on this machine. They start it themselves.",
               "sftd");
  Arguments arguments;
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  arguments.log_level = log_levels.at(arguments.log_level_name);
  if (arguments.foreground || arguments.renewed) return run(arguments, Starter::in_foreground());
  return run(arguments, Starter::detach());
}
