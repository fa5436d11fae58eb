// Owns the objects that iceoryx has once for each process: its error handler, its logger, and the table
// from segment ids to addresses. A process can therefore have only one session with a daemon at a time
// (daemon/process_daemon.h).
#pragma once

#include <cstdint>
#include <span>

#include "core/sync/mutex.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

class IceoryxRuntime {
 public:
  /// Only one object must exist at a time; ProcessDaemon ensures that.
  IceoryxRuntime();
  IceoryxRuntime(const IceoryxRuntime&) = delete;
  IceoryxRuntime& operator=(const IceoryxRuntime&) = delete;

  /// Adds a segment to iceoryx's table of segment addresses. Returns false if its id is taken.
  bool announce_segment(std::uint64_t id, std::span<std::byte> memory) noexcept;
  void withdraw_segment(std::uint64_t id) noexcept;

 private:
  iox::cxx::GenericRAII error_handler_;
  core::Mutex segments_mutex_;
};

}  // namespace sft::shm
