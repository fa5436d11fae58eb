#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/commands.h"
#include "shm_transport/sftd/config.h"
#include "shm_transport/sftd/daemon.h"
#include "shm_transport/sftd/detach.h"
#include "shm_transport/sftd/notify.h"
#include "shm_transport/sftd/pool_choice.h"

namespace {

using namespace sft::shm;

struct Arguments {
  std::string config_file;
  std::optional<std::size_t> pool_mib;
  std::optional<long> idle_exit_s;
  std::optional<std::string> log_level;
  bool foreground = false;
  bool renewed = false;

  bool status = false;
  bool status_as_json = false;
  bool stop = false;
  double stop_timeout_s = 10;
};

void declare_daemon(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "--config", arguments.config_file,
      "Read this configuration file (TOML: pools, limits, groups); options on the command line override "
      "it");
  app.add_option(
         "--pool-mib", arguments.pool_mib,
         std::string("Use this much shared memory for samples, in MiB (default: half of the free space and a "
                     "quarter of the RAM, at most ") +
             std::to_string(default_pool_bytes >> 20) + ")")
      ->check(CLI::Range(4, 1 << 20));
  app.add_option("--idle-exit", arguments.idle_exit_s,
                 "End when no program has used the daemon for this many seconds; 0: never")
      ->check(CLI::Range(0, 1 << 30));
  app.add_flag("--foreground", arguments.foreground,
               "Stay in the terminal, and log to the terminal instead of syslog");
  app.add_option("--log-level", arguments.log_level,
                 "Log messages up to this level: error, warning, info (the default) or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}));
  // The daemon passes this option to itself when it starts afresh, because its process is detached already.
  app.add_flag("--renewed", arguments.renewed)->group("");
}

void declare(CLI::App& app, Arguments& arguments) {
  declare_daemon(app, arguments);
  app.footer(exit_codes_help);
  app.require_subcommand(0, 1);
  CLI::App* status = app.add_subcommand("status", "Show which programs use the memory, and how much of it");
  status->add_flag("--json", arguments.status_as_json, "Print JSON");
  status->callback([&arguments] { arguments.status = true; });
  CLI::App* stop = app.add_subcommand("stop", "End the running sftd; programs that use it go on over UDP");
  stop->add_option("--patience", arguments.stop_timeout_s,
                   "Wait at most this many seconds until sftd has ended")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str();
  stop->callback([&arguments] { arguments.stop = true; });
}

/// Reads the configuration file. Options on the command line override its settings.
sft::Result<Config> settings_of(const Arguments& arguments) {
  sft::Result<Config> config = arguments.config_file.empty() ? Config{} : read_config(arguments.config_file);
  if (!config) return config;
  if (arguments.pool_mib) {
    config->settings.pool_bytes = *arguments.pool_mib << 20;
    config->settings.pools.clear();
  }
  if (arguments.idle_exit_s) config->settings.idle_exit = std::chrono::seconds(*arguments.idle_exit_s);
  if (arguments.log_level) config->log_level = log_level_of(*arguments.log_level);
  return config;
}

/// iceoryx writes to the standard streams, whatever its log level is. Its output only helps to debug iceoryx
/// itself.
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

/// Starts this program again in the same process, with the same settings and no other state.
[[noreturn]] void start_again(const Arguments& arguments) {
  std::vector<std::string> words{"sftd", arguments.foreground ? "--foreground" : "--renewed"};
  if (!arguments.config_file.empty()) words.push_back("--config=" + arguments.config_file);
  if (arguments.pool_mib) words.push_back("--pool-mib=" + std::to_string(*arguments.pool_mib));
  if (arguments.idle_exit_s) words.push_back("--idle-exit=" + std::to_string(*arguments.idle_exit_s));
  if (arguments.log_level) words.push_back("--log-level=" + *arguments.log_level);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv("/proc/self/exe", pointers.data());
  _exit(static_cast<int>(ExitCode::failed));
}

int run(const Arguments& arguments, const ServiceManager& manager, Starter starter) {
  const auto config = settings_of(arguments);
  if (!config) {
    starter.report(ExitCode::bad_config, config.error().message);
    return static_cast<int>(ExitCode::bad_config);
  }
  const LogLevel log_level = config->log_level.value_or(LogLevel::info);
  const Log log(log_level, arguments.foreground ? Log::Target::standard_error : Log::Target::system_log);
  set_up_iceoryx_output(log_level);
  block_signals();
  umask(022);  // lets every account read the files by which programs find the daemon

  const auto give_up = [&starter](const StartFailure& why) {
    starter.report(why.code, why.message);
    _exit(static_cast<int>(why.code));
  };
  auto daemon = Daemon::start(config->settings, log, give_up);
  if (!daemon) {
    starter.report(daemon.error().code, daemon.error().message);
    return static_cast<int>(daemon.error().code);
  }
  starter.report(ExitCode::done, arguments.foreground ? "ready" : "");
  manager.ready((*daemon)->description());
  const Daemon::End end = (*daemon)->serve();
  if (end != Daemon::End::renew) manager.stopping();
  (*daemon)->remove_files(end == Daemon::End::renew);
  // No object is destroyed, because iceoryx would destroy the ports in shared memory while programs use them.
  if (end == Daemon::End::renew) {
    (*daemon)->let_users_notice();
    start_again(arguments);
  }
  _exit(static_cast<int>(ExitCode::done));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Hosts the shared memory of SFT's programs on this machine. Programs start sftd when they need it.",
      "sftd");
  Arguments arguments;
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  if (arguments.status) return static_cast<int>(print_status(arguments.status_as_json));
  if (arguments.stop) {
    const std::chrono::duration<double> timeout(arguments.stop_timeout_s);
    return static_cast<int>(stop_daemon(std::chrono::duration_cast<std::chrono::milliseconds>(timeout)));
  }
  // The daemon leaves the directory in which it was started, so the path must not depend on that directory.
  if (!arguments.config_file.empty())
    arguments.config_file = std::filesystem::absolute(arguments.config_file);
  const char* socket = std::getenv("NOTIFY_SOCKET");
  const ServiceManager manager(socket == nullptr ? "" : socket);
  const bool in_foreground = arguments.foreground || arguments.renewed;
  return run(arguments, manager, in_foreground ? Starter::in_foreground() : Starter::detach());
}
