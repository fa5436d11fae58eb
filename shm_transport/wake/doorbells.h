// The doorbells of a writer's routes. A process's page is mapped once for all writers of a node that ring in
// it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/seam/transport.h"
#include "shm_transport/wake/waker.h"

namespace sft::shm {

/// Each doorbell once, however many readers share it. The list does not change, so that it can be rung while
/// it is being replaced.
class Doorbells final : public Errand {
 public:
  /// `page`: null for a reader that cannot be woken. `gate`: of its maximum rate, null if it has none. Before
  /// the first ring.
  void add(std::shared_ptr<core::DoorbellPage> page, std::uint32_t slot,
           std::shared_ptr<const core::RateGate> gate);
  std::size_t size() const { return bells_.size(); }

  // The publisher's thread, on which the gates say what passes.

  /// Whether any reader wants the sample at hand.
  bool wanted() const noexcept;
  /// Tells those that want it: nobody is woken for what it would skip. So many sleep, and are to be woken.
  [[nodiscard]] std::size_t announce() const noexcept;

  /// Any thread: wakes all of them.
  void run() const noexcept override;

 private:
  struct Bell {
    core::Doorbell* bell = nullptr;
    bool always = false;  ///< for a reader without limit
    std::vector<std::shared_ptr<const core::RateGate>> gates{};
    mutable std::atomic<bool> due{false};  ///< to be woken
    bool wanted() const noexcept;
  };
  std::vector<std::shared_ptr<core::DoorbellPage>> pages_;
  std::deque<Bell> bells_;
};

/// Any thread.
class DoorbellPages {
 public:
  /// `waker`: the thread that wakes readers where several sleep.
  explicit DoorbellPages(core::ThreadSpec waker = "sft-wake") : waker_(std::move(waker)) {}

  /// The page that a reader's doorbell is in, or why it cannot be rung. `accounts`: whose pages may be
  /// opened.
  Result<std::shared_ptr<core::DoorbellPage>> page_of(const core::Route& route,
                                                      const core::TrustedAccounts& accounts);
  /// Doorbells that cannot be opened (their process is gone) are left out.
  std::shared_ptr<const Doorbells> doorbells_of(const std::vector<core::Route>& routes,
                                                const core::TrustedAccounts& accounts = {});

  /// The publisher's thread: rings for the sample at hand. A single sleeper it wakes itself; several it
  /// leaves to a thread of the node.
  void ring(const std::shared_ptr<const Doorbells>& bells) noexcept;

 private:
  Result<std::shared_ptr<core::DoorbellPage>> open(std::uint64_t id, const core::TrustedAccounts& accounts);

  std::string nameless_link(std::uint64_t id);

  // Of the thread that sets routes.
  std::map<std::uint64_t, std::string> nameless_;  ///< pages without paths (core/platform/doorbell.h)
  std::chrono::steady_clock::time_point next_search_{};

  Waker waker_;
  std::mutex mutex_;
  std::map<std::uint64_t, std::weak_ptr<core::DoorbellPage>> pages_;
};

}  // namespace sft::shm
