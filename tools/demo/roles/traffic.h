// The data that a host's network interface receives, without control traffic.
//
// All bytes are the kernel's own counters of the interface, link layer included. Control traffic comes in
// rare bursts, so that its rate before a run says little about the bytes in it: with samples of 82 bytes the
// error would be as large as the figure. So it is counted as it passes. A packet socket is shown all frames
// that are not data (its filter drops the data), and the meter adds up their lengths.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/platform/file_descriptor.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::demo {

class TrafficMeter {
 public:
  static Result<std::unique_ptr<TrafficMeter>> open(const std::string& interface);

  /// Bytes of data that were received since it was opened. Any thread.
  std::int64_t data_received();

 private:
  TrafficMeter(std::string interface, core::FileDescriptor packets);
  void count_control() SFT_REQUIRES(mutex_);

  const std::string interface_;
  const core::FileDescriptor packets_;
  core::Mutex mutex_;
  std::int64_t not_data_ SFT_GUARDED_BY(mutex_) =
      0;  // received as control traffic, or before the meter was opened
};

}  // namespace sft::demo
