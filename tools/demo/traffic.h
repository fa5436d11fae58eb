// Counts the bytes of samples that a host's interface receives, link layer included.
//
// The kernel counts all bytes of the interface. The bytes of control traffic are subtracted from that
// number. To count them, a packet socket receives all frames except data, which its filter drops. A rate of
// control traffic that was measured earlier would not be exact enough, since a node announces itself in
// bursts every few seconds, and small samples take fewer bytes than one burst.
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

  /// Returns the number of bytes of data since a fixed time in the past. Any thread may call it.
  std::int64_t data_bytes();

 private:
  TrafficMeter(std::string interface, core::FileDescriptor packets)
      : interface_(std::move(interface)), packets_(std::move(packets)) {}
  void count_control() SFT_REQUIRES(mutex_);

  const std::string interface_;
  const core::FileDescriptor packets_;
  core::Mutex mutex_;
  std::uint64_t control_bytes_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::demo
