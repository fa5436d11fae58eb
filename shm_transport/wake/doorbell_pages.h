// Opens the doorbells of readers. The page with the doorbells of a process is mapped once for all writers of
// a node.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"
#include "shm_transport/wake/doorbells.h"
#include "shm_transport/wake/waker.h"

namespace sft::shm {

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

  Waker& waker() { return waker_; }

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
