// The doorbells of the readers to which a writer has routes.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/seam/transport.h"

namespace sft::shm {

/// The doorbells of a writer's readers. Each doorbell is in the list once, however many readers share it.
/// The list does not change after the first ring. So the list can be rung while a new list replaces it.
class Doorbells {
 public:
  /// Adds the doorbell of a reader. Must be called before the first ring. `page` is null if the reader
  /// cannot be woken. `gate` is the gate of the reader's maximum rate; null if the reader has no maximum
  /// rate.
  void add(std::shared_ptr<core::DoorbellPage> page, std::uint32_t slot,
           std::shared_ptr<const core::Gate> gate);
  std::size_t size() const { return bells_.size(); }

  // Only the thread of the publisher may call the next two functions, because they use the decision of the
  // gates about the current sample. Only that thread may read these decisions.

  /// Returns whether any reader wants the current sample.
  bool wanted() const noexcept;
  /// Counts a ring at the doorbell of each reader that wants the sample, so that no reader is woken for a
  /// sample that it would skip. Returns the number of these readers that sleep and must be woken by wake().
  [[nodiscard]] std::size_t announce() const noexcept;

  /// Wakes the readers that announce() has found asleep. Any thread may call this.
  void wake() const noexcept;

 private:
  struct Bell {
    core::Doorbell* bell = nullptr;
    bool always = false;  ///< true if a reader without a maximum rate has this doorbell
    std::vector<std::shared_ptr<const core::Gate>> gates{};
    mutable std::atomic<bool> wake_due{false};  ///< true from announce() until wake()
    bool wanted() const noexcept;
  };
  std::vector<std::shared_ptr<core::DoorbellPage>> pages_;
  std::deque<Bell> bells_;

  friend class Waker;
  // The members for the queue of the waker. `self_` keeps this object alive while it is queued.
  mutable std::atomic<bool> queued_{false};
  mutable std::shared_ptr<const Doorbells> self_;
  mutable const Doorbells* next_ = nullptr;
};

}  // namespace sft::shm
