// Rings the doorbells of the readers to which a writer has routes. The page with the doorbells of a process
// is mapped once for all writers of a node.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"
#include "shm_transport/wake/waker.h"

namespace sft::shm {

/// The doorbells of a writer's readers. Each doorbell is in the list once, however many readers share it.
/// The list does not change after the first ring. So the list can be rung while a new list replaces it.
class Doorbells final : public WakeTask {
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
  /// sample that it would skip. Returns the number of these readers that sleep and must be woken by run().
  [[nodiscard]] std::size_t announce() const noexcept;

  /// Wakes the readers that announce() has found asleep. Any thread may call this.
  void run() const noexcept override;

 private:
  struct Bell {
    core::Doorbell* bell = nullptr;
    bool always = false;  ///< true if a reader without a maximum rate has this doorbell
    std::vector<std::shared_ptr<const core::Gate>> gates{};
    mutable std::atomic<bool> wake_due{false};  ///< true from announce() until run()
    bool wanted() const noexcept;
  };
  std::vector<std::shared_ptr<core::DoorbellPage>> pages_;
  std::deque<Bell> bells_;
};

/// The pages of doorbells that a node has opened. Any thread may call a function, unless the comment of the
/// function names a thread.
class DoorbellPages {
 public:
  /// `waker` describes the thread that wakes readers if several sleep.
  explicit DoorbellPages(core::ThreadSpec waker = "sft-wake") : waker_(std::move(waker)) {}

  /// Opens the page with the doorbell of this reader. The error says why the doorbell cannot be rung.
  /// `accounts` are the accounts whose pages may be opened.
  Result<std::shared_ptr<core::DoorbellPage>> page_of(const core::Route& route,
                                                      const core::TrustedAccounts& accounts);
  /// Makes the list of doorbells for these routes. A doorbell that cannot be opened, because its process is
  /// gone, gets an entry that wakes no reader.
  std::shared_ptr<const Doorbells> doorbells_of(const std::vector<core::Route>& routes,
                                                const core::TrustedAccounts& accounts = {});

  /// Rings the doorbells for the current sample. Must be called on the thread of the publisher. This thread
  /// wakes a single sleeping reader itself. If several readers sleep, a thread of the node wakes them.
  void ring(const std::shared_ptr<const Doorbells>& bells) noexcept;

 private:
  Result<std::shared_ptr<core::DoorbellPage>> open(std::uint64_t id, const core::TrustedAccounts& accounts);

  std::string nameless_link(std::uint64_t id);

  // Only the thread that sets routes uses the next two members.
  std::map<std::uint64_t, std::string> nameless_;  ///< links to pages without a path, by the id of the page
  std::chrono::steady_clock::time_point next_search_{};

  Waker waker_;
  core::Mutex mutex_;
  std::map<std::uint64_t, std::weak_ptr<core::DoorbellPage>> pages_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
