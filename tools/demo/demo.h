// One run of the demo: waits until all nodes have found each other and discovery is quiet, lets the lidar
// publish, and measures what that costs.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "tools/demo/screen/display.h"
#include "tools/demo/screen/figures.h"
#include "tools/demo/stage/stage.h"
#include "tools/terminal/stop.h"

namespace sft::demo {

/// The options of the command line.
struct DemoOptions {
  double hz = 10;
  double seconds = 10;
  bool arr = false;  ///< the fields of all subscribers are recorded, not declared
  std::optional<std::filesystem::path> json{};

  std::uint64_t samples() const {
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(hz * seconds + 0.5));
  }
};

class Demo {
 public:
  Demo(const DemoOptions& options, Stage& stage, tool::Stop& stop, Display& display)
      : options_(options), stage_(stage), stop_(stop), display_(display) {}

  Result<RunFigures> run();

 private:
  /// The reports of all roles, which are asked one after the other.
  struct Snapshot {
    Clock::time_point at;
    PublisherReport publisher;
    std::vector<SubscriberReport> subscribers;
  };

  /// Asks all roles for their reports. `says_so`: the user is told which role has not answered yet.
  Result<Snapshot> look(const Order& order = {}, bool says_so = false);
  Result<void> await_readiness();
  Result<void> let_it_settle();
  Result<void> publish();
  Result<void> await_arrival();

  /// Waits until `then` and returns false, or until the user asks to stop and returns true. A request to stop
  /// counts once.
  bool stop_asked_before(Clock::time_point then);
  /// Waits until `then`, before the first cloud is published, and tells the user for what. Returns an error
  /// if the user asks to stop.
  Result<void> wait_until(Clock::time_point then, const std::string& what);
  void introduce() const;
  std::string missing(const Snapshot& now, bool any_transport) const;
  bool served_as_wished(const Snapshot& now, std::size_t subscriber, bool any_transport) const;
  Error not_ready(const Snapshot& now) const;
  RunFigures figures(const Snapshot& now) const;

  const DemoOptions& options_;
  Stage& stage_;
  tool::Stop& stop_;
  Display& display_;
  Snapshot begin_;  ///< just before the first sample
  Snapshot last_;
  bool is_over_ = false;  ///< samples that have not arrived by now are lost
};

}  // namespace sft::demo
