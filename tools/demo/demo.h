// One run of the demo: waits until all nodes have found each other, lets the lidar publish, and gathers the
// figures.
#pragma once

#include <string>

#include "tools/demo/screen/display.h"
#include "tools/demo/screen/figures.h"
#include "tools/demo/stage/stage.h"
#include "tools/terminal/stop.h"

namespace sft::demo {

class Demo {
 public:
  /// `setting` has what is known before the run: the input, the rate and the like.
  Demo(RunFigures setting, Stage& stage, tool::Stop& stop, Display& display)
      : setting_(std::move(setting)), stage_(stage), stop_(stop), display_(display) {}

  /// Ctrl-C ends the publishing; before anything is published it is the error.
  Result<RunFigures> run();

 private:
  void introduce() const;
  Result<void> await_readiness();
  Result<void> publish();
  Result<void> await_arrival();
  /// Lets a moment pass, and takes the reports of the roles.
  Result<void> wait_a_moment();
  bool stop_asked();
  bool all_arrived() const;
  RunFigures figures(bool is_over) const;

  const RunFigures setting_;
  Stage& stage_;
  tool::Stop& stop_;
  Display& display_;
};

}  // namespace sft::demo
