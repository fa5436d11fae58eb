// One run of the demo: waits until everybody found each other and discovery is quiet, lets the LiDAR publish,
// and collects what it cost.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include "tools/demo/options.h"
#include "tools/demo/screen/display.h"
#include "tools/demo/screen/figures.h"
#include "tools/demo/stage/stage.h"
#include "tools/terminal/stop.h"

namespace sft::demo {

class Demo {
 public:
  Demo(const DemoOptions& options, const CloudSource& source, Stage& stage, tool::Stop& stop,
       Display& display);

  Result<RunFigures> run();

 private:
  /// What all roles report, asked one after the other.
  struct Snapshot {
    Clock::time_point at;
    PublisherReport publisher;
    std::vector<SubscriberReport> subscribers;
  };

  Result<Snapshot> look(const Order& order = {});
  /// The first one: waits until all roles have started, and says so.
  Result<Snapshot> first_look();
  Result<Snapshot> look(const Order& order, const std::function<WhileWaiting(const std::string&)>& waiting);
  Result<void> await_readiness();
  Result<void> let_it_settle();
  Result<void> publish();
  Result<void> await_arrival();

  /// Waits until then, or until the user asks to stop, which is true once for each time.
  bool stop_asked_before(Clock::time_point then);
  /// Waits before anything is published, and says for what. The error is that the user wants to stop.
  Result<void> wait_until(Clock::time_point then, const std::string& what);
  void introduce() const;
  std::string missing(const Snapshot& now, bool any_transport) const;
  bool served_as_wished(const Snapshot& now, std::size_t subscriber, bool any_transport) const;
  Error not_ready(const Snapshot& now) const;
  RunFigures figures(const Snapshot& now) const;
  void note_idle_traffic(const Snapshot& now);
  double control_per_node(const Snapshot& now) const;

  const DemoOptions& options_;
  const CloudSource& source_;
  Stage& stage_;
  tool::Stop& stop_;
  Display& display_;
  Snapshot settled_;  ///< when all had found each other and nothing was published yet
  Snapshot begin_;    ///< just before the first sample
  Snapshot last_;
  unsigned control_periods_ = 0;  ///< in idle_bytes_per_s_
  std::optional<double> idle_bytes_per_s_;
  bool is_over_ = false;  ///< what has not arrived by now is lost
};

}  // namespace sft::demo
