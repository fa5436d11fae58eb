// Ctrl-C and its relatives, as something that can be waited for. From its construction on they no longer end
// the process.
#pragma once

#include "examples/demo/channel.h"
#include "examples/demo/descriptor.h"

namespace sft::demo {

class Interrupt {
 public:
  Interrupt();

  /// Waits until then; true at once, and only once, when the user wants to stop.
  bool wait_until(Clock::time_point then);

 private:
  Descriptor signals_;
};

}  // namespace sft::demo
