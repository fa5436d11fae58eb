// Assigns doorbells to the subscribers of a node. A subscriber with neither a callback nor a file
// descriptor has its own doorbell. All subscribers with a callback share one doorbell, because one thread
// of the node waits for all of them. All subscribers with a file descriptor share another doorbell. Any
// thread may call these functions.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class WakeSlots {
 public:
  // The shared slots, which always exist.
  static constexpr std::uint32_t dispatcher = 0;
  static constexpr std::uint32_t poller = 1;

  WakeSlots();

  Result<std::uint32_t> take();
  void give_back(std::uint32_t slot);

  /// Ends all present and later waits of all subscribers. A signal handler may call this function.
  void interrupt() noexcept;
  const std::atomic<bool>& interrupted() const { return interrupted_; }

  Doorbell& at(std::uint32_t slot) { return page_->at(slot); }
  /// Returns the id by which other processes find the page, or 0 if no other process can ring its
  /// doorbells.
  std::uint64_t page_id() const { return page_->id(); }

 private:
  const std::unique_ptr<DoorbellPage> page_;
  std::atomic<bool> interrupted_{false};
  Mutex mutex_;
  std::vector<std::uint32_t> free_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
