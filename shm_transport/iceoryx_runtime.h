// What iceoryx keeps once per process, owned here and nowhere else: its error handler, its logger, and the
// table from segment ids to addresses. So there can be only one session with a daemon at a time in a process,
// which all nodes of the process share by reference counting. This is the one global object of the transport.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "shm_transport/daemon_link.h"
#include "shm_transport/iceoryx.h"

namespace sft::shm {

class IceoryxRuntime {
 public:
  /// The process's runtime; made if nobody holds it now.
  static std::shared_ptr<IceoryxRuntime> shared();

  DaemonLink& daemon() { return daemon_; }

  /// Enters a segment into iceoryx's table; false if its id is taken.
  bool announce_segment(std::uint64_t id, std::span<std::byte> memory) noexcept;
  void withdraw_segment(std::uint64_t id) noexcept;

  /// Errors that iceoryx reported and went on from; it would have aborted the process at some of them.
  static std::uint64_t errors() noexcept;

 private:
  IceoryxRuntime();

  iox::cxx::GenericRAII error_handler_;
  std::mutex segments_mutex_;
  DaemonLink daemon_;
};

}  // namespace sft::shm
