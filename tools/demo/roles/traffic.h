// The traffic of a host's network interface, and its share of control traffic.
//
// All bytes are the kernel's own counters of the interface, link layer included. Control traffic comes in
// rare bursts (a node announces itself every few seconds, to everybody), so that a rate measured before a run
// of a few seconds says little about the bytes in it: with samples of 82 bytes the error would be as large as
// the figure. Therefore control traffic is counted as it passes: a packet socket receives all frames that are
// not data (its filter drops the data), and the meter adds up the lengths.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/platform/file_descriptor.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::demo {

/// Bytes that were received since a moment in the past.
struct Traffic {
  std::uint64_t received = 0;
  std::uint64_t control_received = 0;

  friend Traffic operator-(const Traffic& after, const Traffic& before) {
    return {after.received - before.received, after.control_received - before.control_received};
  }
  std::int64_t data_received() const { return static_cast<std::int64_t>(received - control_received); }
};

class TrafficMeter {
 public:
  static Result<std::unique_ptr<TrafficMeter>> open(const std::string& interface);

  /// Any thread.
  Traffic read();

 private:
  TrafficMeter(std::string interface, core::FileDescriptor packets)
      : interface_(std::move(interface)), packets_(std::move(packets)) {}
  void count_control() SFT_REQUIRES(mutex_);

  const std::string interface_;
  const core::FileDescriptor packets_;
  core::Mutex mutex_;
  std::uint64_t control_received_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::demo
