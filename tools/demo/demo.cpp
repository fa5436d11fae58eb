// sft_demo shows on one machine what Selective Field Transmission does. A lidar publishes point clouds.
// Subscribers on other hosts receive only the fields that they need. A subscriber on the lidar's own host
// reads its fields in shared memory.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>

#include "tools/demo/display.h"
#include "tools/demo/scene.h"
#include "tools/demo/stage.h"
#include "tools/terminal/file_error.h"
#include "tools/terminal/stop.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// The limit for the first answer of a role, which comes when its node is open
constexpr seconds timeout_for_answer{15};
constexpr seconds timeout_for_matching{20};
constexpr seconds timeout_for_shared_memory{8};
constexpr seconds timeout_for_arrival{2};
// After DDS participants have found each other, they repeat their announcements for about this long. In
// this time, the daemons that the hosts have started become ready, and the nodes announce it.
constexpr seconds settling{5};
constexpr seconds refresh{1};
constexpr milliseconds poll_interval{20};

/// One run: waits until all nodes have found each other and discovery is quiet, makes the lidar publish, and
/// measures the bytes and the processor time.
class Demo {
 public:
  Demo(const RunOptions& options, Stage& stage, tool::Stop& stop, Display& display)
      : options_(options), stage_(stage), stop_(stop), display_(display) {
    run_.hz = options.hz;
    run_.hosts = stage.real_hosts() ? static_cast<unsigned>(subscriber_roles.size()) : 1;
    for (const SubscriberRole& role : subscriber_roles) {
      SubscriberFigures s;
      s.name = role.name;
      s.max_rate_hz = role.max_rate_hz;
      s.recorded = options.is_recorded;
      s.metered = stage.real_hosts();
      run_.subscribers.push_back(s);
    }
  }

  Result<RunFigures> run() {
    introduce();
    return await_readiness()
        .and_then([this] { return let_it_settle(); })
        .and_then([this] { return publish(); })
        .and_then([this] { return await_arrival(); })
        .map([this] { return run_; });
  }

 private:
  /// Waits until `then` and returns false. Returns true earlier if the user requests a stop. Each request
  /// is reported only once.
  bool stop_asked_before(Clock::time_point then) {
    const bool asked = stop_.wait_for(then - Clock::now());
    stop_.forget();
    return asked;
  }

  /// Waits until `then`, before the first cloud is published. `what` names for the user what the demo waits
  /// for. Returns an error if the user requests a stop.
  Result<void> wait_until(Clock::time_point then, const std::string& what) {
    display_.status(what + " ...");
    return stop_asked_before(then) ? fail(Errc::unavailable, stopped_early) : Result<void>();
  }

  Result<nlohmann::json> report_of(Channel& channel, const std::string& role, const char* order) {
    return ask(channel, role, order, timeout_for_answer, has_begun_ ? nullptr : &stop_);
  }

  /// Asks all roles for their reports, one after the other. The publisher is asked last, so that it counts
  /// all samples that subscribers have received by now.
  Result<void> look(const char* order = "") {
    for (std::size_t i = 0; i < run_.subscribers.size(); ++i) {
      const auto report = report_of(stage_.subscriber(i), run_.subscribers[i].name, "");
      if (!report) return tl::unexpected(report.error());
      static_cast<SubscriberReport&>(run_.subscribers[i]) = report->get<SubscriberReport>();
    }
    const auto report = report_of(stage_.publisher(), "publisher", order);
    if (!report) return tl::unexpected(report.error());
    publisher_ = report->get<PublisherReport>();
    looked_at_ = Clock::now();
    run_.samples = publisher_.published;
    for (SubscriberFigures& s : run_.subscribers) {
      const ReaderReport* reader = reader_called(s.name);
      s.withheld = reader == nullptr ? 0 : reader->withheld;
      s.full_bytes = publisher_.full_bytes;
    }
    return {};
  }

  /// Returns the publisher's report on the reader with this name; null if the publisher does not know such
  /// a reader.
  const ReaderReport* reader_called(const std::string& name) const {
    const auto reader = std::ranges::find(publisher_.readers, name, &ReaderReport::node);
    return reader == publisher_.readers.end() ? nullptr : &*reader;
  }

  bool is_local(const SubscriberFigures& s) const { return &s == &run_.subscribers.back(); }

  bool served_as_wished(const SubscriberFigures& s, bool any_transport) const {
    const ReaderReport* reader = reader_called(s.name);
    if (reader == nullptr || !reader->served || !s.matched) return false;
    return any_transport || !is_local(s) || (reader->transport == "shm" && s.in_shared_memory());
  }

  /// Returns the names of the subscribers that are not served yet: "health, localiser".
  std::string missing(bool any_transport) const {
    std::string names;
    for (const SubscriberFigures& s : run_.subscribers)
      if (!served_as_wished(s, any_transport)) names += (names.empty() ? "" : ", ") + s.name;
    return names;
  }

  Error not_ready() const {
    std::string text = fmt::format("not everybody was served within {} s:", timeout_for_matching.count());
    for (const SubscriberFigures& s : run_.subscribers) {
      if (served_as_wished(s, true)) continue;
      text += fmt::format(" {} ({})", s.name, s.reason.empty() ? "found no publisher" : s.reason);
    }
    return {Errc::unavailable, text};
  }

  void introduce() const {
    display_.say(stage_.real_hosts()
                     ? "Five hosts, each in namespaces of its own, on an emulated switch:"
                     : "No real hosts (" + stage_.why_not() +
                           "): everything runs on this machine, with the network path forced over loopback:");
    display_.say(fmt::format("  lidar    publishes clouds of {} x {} points, {:g} a second", Scene::rows,
                             Scene::columns, options_.hz));
    for (const SubscriberRole& role : subscriber_roles)
      display_.say(fmt::format("  {:<8} {:<9} {}", role.host, role.name, role.purpose));
  }

  Result<void> await_readiness() {
    const auto start = Clock::now();
    for (;;) {
      if (Result<void> looked = look(); !looked) return looked;
      const auto waited = looked_at_ - start;
      const std::string names = missing(waited > timeout_for_shared_memory);
      if (names.empty()) {
        display_.say(fmt::format("All {} subscribers found the publisher within {:.1f} s.",
                                 run_.subscribers.size(), std::chrono::duration<double>(waited).count()));
        for (const std::string& line : format_refusals(publisher_)) display_.say(line);
        return {};
      }
      if (waited > timeout_for_matching) return tl::unexpected(not_ready());
      if (Result<void> slept = wait_until(looked_at_ + poll_interval, "Not served yet: " + names); !slept)
        return slept;
    }
  }

  Result<void> let_it_settle() {
    if (!stage_.real_hosts()) return {};
    return wait_until(Clock::now() + settling,
                      fmt::format("Waiting until discovery is quiet, {} s", settling.count()));
  }

  Result<void> publish() {
    has_begun_ = true;
    if (Result<void> looked = look("begin"); !looked) return looked;
    for (SubscriberFigures& s : run_.subscribers) s.begin = s.counts;
    const auto start = looked_at_;
    while (!publisher_.finished) {
      const bool stop = stop_asked_before(looked_at_ + refresh);
      Result<void> looked = look(stop ? "end" : "");
      if (!looked) return looked;
      display_.status(format_progress(run_, std::chrono::duration<double>(looked_at_ - start).count()));
    }
    return {};
  }

  Result<void> await_arrival() {
    const auto deadline = Clock::now() + timeout_for_arrival;
    for (bool is_over = false; !is_over;) {
      if (Result<void> looked = look(); !looked) return looked;
      const bool all_there = std::ranges::all_of(run_.subscribers, [this](const SubscriberFigures& s) {
        return s.counts.samples + s.lost + s.withheld >= run_.samples;
      });
      is_over = all_there || looked_at_ > deadline || stop_asked_before(looked_at_ + poll_interval);
    }
    for (SubscriberFigures& s : run_.subscribers) s.count_missing_as_lost(run_.samples);
    return {};
  }

  const RunOptions& options_;
  Stage& stage_;
  tool::Stop& stop_;
  Display& display_;
  RunFigures run_;
  PublisherReport publisher_;
  Clock::time_point looked_at_;
  bool has_begun_ = false;  ///< true once the first cloud has been published
};

/// Runs the demo. `json` is the path of the file for the figures; empty: no file is written.
Result<void> run(const RunOptions& options, const std::string& json) {
  // The file is opened before the run, so that the user learns at once if it cannot be written.
  if (!json.empty() && !std::ofstream(json, std::ios::app))
    return fail(Errc::invalid_argument, json + " cannot be written; give another file to --json");
  Display display;
  tool::Stop stop;
  display.status("Setting up the hosts ...");
  const Result<std::unique_ptr<Stage>> stage = Stage::set_up(options);
  if (!stage) return tl::unexpected(stage.error());
  const Result<RunFigures> figures = Demo(options, **stage, stop, display).run();
  if (!figures) return tl::unexpected(figures.error());
  display.conclude(*figures);
  if (json.empty()) return {};
  std::ofstream file(json);
  file << to_json(*figures).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  if (file.flush()) return {};
  return tl::unexpected(tool::cannot_be_written(json));
}

}  // namespace

}  // namespace sft::demo

int main(int argc, char** argv) try {
  sft::demo::RunOptions options;
  double seconds = 10;
  std::string json;
  CLI::App app("Shows which fields of a lidar's point clouds each subscriber is sent.");
  app.get_formatter()->column_width(20);
  app.get_formatter()->label("TEXT", "PATH");
  app.add_option("--hz", options.hz, "Publish this many clouds per second, 0.1 to 1000")
      ->capture_default_str()
      ->type_name("HZ")
      ->check(CLI::Range(0.1, 1000.0).description(""));
  app.add_option("--seconds", seconds, "Publish for this many seconds, 0.1 to 86400")
      ->capture_default_str()
      ->type_name("S")
      ->check(CLI::Range(0.1, 86400.0).description(""));
  app.add_flag("--arr", options.is_recorded,
               "Record the fields that each subscriber reads, and\ndeclare none");
  app.add_option("--json", json, "Write the figures to a file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  options.samples = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(options.hz * seconds + 0.5));
  const sft::Result<void> done = sft::demo::run(options, json);
  if (!done) std::fprintf(stderr, "sft_demo: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "sft_demo: %s\n", error.what());
  return 1;
}
