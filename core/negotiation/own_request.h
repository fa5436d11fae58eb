// The request of one of our readers. Each change makes it a newer request: its sequence grows by one. Uses no
// clock, thread or I/O.
#pragma once

#include <cstdint>

#include "core/control/control.h"
#include "sft/selection.h"
#include "sft/status.h"

namespace sft::core {

class OwnRequest {
 public:
  /// `request` outlives this object.
  explicit OwnRequest(Request& request) : request_(request) {}

  // Each returns true if the request has changed.
  bool needs(const Selection& selection);
  bool takes_a_sample_per(std::uint32_t min_period_us);
  /// Called when samples of a writer now arrive by that path, or no longer arrive. If the path is lost by
  /// which retained samples came, they come again from the beginning.
  bool connection_changed(EndpointId writer, TransportKind path, bool connected);
  bool history_began(EndpointId writer);
  /// Called when shared memory is lost. All attachments end.
  bool memory_lost();

 private:
  Request& request_;
};

}  // namespace sft::core
