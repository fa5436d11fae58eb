// One writer that one of our readers should receive from, and the paths by which it should receive.
// Negotiation::hearing() derives these.
#pragma once

#include <cstdint>

#include "core/control/control.h"
#include "core/seam/transport.h"
#include "sft/status.h"

namespace sft::core {

struct Hearing {
  Source source;
  Qos offered;
  std::uint32_t owed = 0;  ///< the number of retained samples that the writer should send before all others
  bool memory = false;     ///< true: connect to the writer in shared memory
  bool network = false;
  SubscriberStatus::Writer status;
};

}  // namespace sft::core
