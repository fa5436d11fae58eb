// Counts SFT's control datagrams, which contain no part of a sample, on this host's interface in both
// directions.
#pragma once

#include <cstdint>

#include "core/platform/file_descriptor.h"

namespace sft::bench {

struct ControlTraffic {
  std::int64_t bytes = 0;  ///< bytes of frames, with all headers
  std::int64_t datagrams = 0;
};

class ControlCounter {
 public:
  /// Ends the program with a message if it cannot capture packets, for example without root's rights.
  ControlCounter();

  /// Returns the traffic since the last call; in the first call, since the counter was made.
  ControlTraffic read() const;

 private:
  core::FileDescriptor packets_;
};

}  // namespace sft::bench
