// sft_demo shows on one machine what Selective Field Transmission does. A lidar publishes point clouds.
// Subscribers on other hosts are sent the fields that they need, and one on the lidar's own host reads its
// fields in shared memory.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "tools/demo/demo.h"

namespace sft::demo {

namespace {

struct Options {
  std::optional<std::filesystem::path> input{};  ///< empty: the generated scene
  double hz = 10;
  double seconds = 10;
  bool arr = false;  ///< the fields of all subscribers are recorded, not declared
  std::optional<std::filesystem::path> json{};

  std::uint64_t samples() const {
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(hz * seconds + 0.5));
  }
};

Result<void> run(const Options& options) {
  // Tried before the run, since a user does not want to learn after it that the figures cannot be written.
  if (options.json && !std::ofstream(*options.json, std::ios::app)) {
    return fail(Errc::invalid_argument,
                options.json->native() + " cannot be written; give another file to --json");
  }
  PublishingPlan plan{.hz = options.hz, .samples = options.samples()};
  if (options.input) {
    Result<Clouds> clouds = read_point_clouds(*options.input, plan.samples);
    if (!clouds) return tl::unexpected(clouds.error());
    plan.clouds = std::move(*clouds);
  }

  tool::Stop stop;
  Display display;
  display.waiting("Setting up the hosts");
  const auto stage = Stage::set_up(plan, options.arr);
  if (!stage) return tl::unexpected(stage.error());
  display.say((*stage)->real_hosts()
                  ? "Five hosts, each in namespaces of its own, on an emulated switch:"
                  : "No real hosts (" + (*stage)->why_not() +
                        "): everything runs on this machine, with the network path forced over loopback:");
  const RunFigures setting{.input = plan.clouds.name,
                           .message_shape = plan.clouds.shape,
                           .hz = options.hz,
                           .recorded = options.arr};
  const Result<RunFigures> figures = Demo(setting, **stage, stop, display).run();
  if (!figures) return tl::unexpected(figures.error());
  display.conclude(*figures);
  if (!options.json) return {};
  std::ofstream json(*options.json);
  json << to_json(*figures) << std::flush;
  return json ? Result<void>() : fail(Errc::system, options.json->native() + " could not be written");
}

}  // namespace

}  // namespace sft::demo

int main(int argc, char** argv) try {
  sft::demo::Options options;
  CLI::App app("Shows which fields of a lidar's point clouds each subscriber is sent.");
  app.get_formatter()->column_width(20);
  app.get_formatter()->label("TEXT", "PATH");
  app.add_option("--input", options.input,
                 "Publish the cloud of a file (.cdr: one message in CDR),\n"
                 "or those of a directory of them, again and again.\n"
                 "Default: a generated scene of 128 x 1024 points");
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
