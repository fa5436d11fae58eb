// sft_demo shows on one machine what Selective Field Transmission does. A lidar publishes point clouds.
// Subscribers on other hosts are sent the fields that they need, and one on the lidar's own host reads its
// fields in shared memory.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/demo/demo.h"

namespace sft::demo {

namespace {

/// Called before the run, since a user does not want to learn after the run that the figures cannot be
/// written.
Result<void> check_writable(const std::filesystem::path& path) {
  std::error_code error;
  const bool exists = std::filesystem::exists(path, error);
  const std::filesystem::path directory = path.has_parent_path() ? path.parent_path() : ".";
  const bool writable = exists
                            ? !std::filesystem::is_directory(path, error) && access(path.c_str(), W_OK) == 0
                            : access(directory.c_str(), W_OK | X_OK) == 0;
  if (writable) return {};
  return fail(Errc::invalid_argument, path.native() + " cannot be written; give another file to --json");
}

Result<void> write_json(const std::filesystem::path& path, const RunFigures& figures) {
  std::ofstream file(path);
  file << to_json(figures).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  if (file.flush()) return {};
  return fail(Errc::system, path.native() + " could not be written");
}

Result<void> run(const DemoOptions& options) {
  if (options.json) {
    if (Result<void> writable = check_writable(*options.json); !writable) return writable;
  }
  Display display;
  tool::Stop stop;
  display.waiting("Setting up the hosts", Clock::now());
  const Result<std::unique_ptr<Stage>> stage = Stage::set_up(options.arr);
  if (!stage) return tl::unexpected(stage.error());
  display.say((*stage)->real_hosts()
                  ? "Five hosts, each in namespaces of its own, on an emulated switch:"
                  : "No real hosts (" + (*stage)->why_not() +
                        "): everything runs on this machine, with the network path forced over loopback:");
  const Result<RunFigures> figures = Demo(options, **stage, stop, display).run();
  if (!figures) return tl::unexpected(figures.error());
  display.conclude(*figures);
  return options.json ? write_json(*options.json, *figures) : Result<void>();
}

}  // namespace

}  // namespace sft::demo

int main(int argc, char** argv) try {
  sft::demo::DemoOptions options;
  CLI::App app("Shows which fields of a lidar's point clouds each subscriber is sent.");
  app.get_formatter()->column_width(20);
  app.get_formatter()->label("TEXT", "PATH");
  app.add_option("--hz", options.hz, "Publish this many clouds per second, 0.1 to 1000")
      ->capture_default_str()
      ->type_name("HZ")
      ->check(CLI::Range(0.1, 1000.0).description(""));
  app.add_option("--seconds", options.seconds, "Publish for this many seconds, 0.1 to 86400")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.1, 86400.0).description(""));
  app.add_flag("--arr", options.arr, "Record the fields that each subscriber reads, and\ndeclare none");
  app.add_option("--json", options.json, "Write the figures to a file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  const sft::Result<void> done = sft::demo::run(options);
  if (!done) std::fprintf(stderr, "sft_demo: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "sft_demo: %s\n", error.what());
  return 1;
}
