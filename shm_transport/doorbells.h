// The doorbells of a writer's routes. A process's page is mapped once for all writers of a node that ring in
// it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/doorbell.h"
#include "core/transport.h"

namespace sft::shm {

/// Each doorbell once, however many readers share it. Immutable, so that it can be rung while it is being
/// replaced.
class Doorbells {
 public:
  /// `page`: null for a reader that cannot be woken. `gate`: of its maximum rate, null if it has none.
  void add(std::shared_ptr<core::DoorbellPage> page, std::uint32_t slot,
           std::shared_ptr<const core::RateGate> gate);

  // The publisher's thread, on which the gates say what passes.

  /// Whether any reader wants the sample at hand.
  bool wanted() const noexcept;
  /// Those that want it: nobody is woken for what it would skip.
  void ring() const noexcept;

 private:
  struct Bell {
    core::Doorbell* bell;
    bool always;  ///< for a reader without limit
    std::vector<std::shared_ptr<const core::RateGate>> gates;
    bool wanted() const noexcept;
  };
  std::vector<std::shared_ptr<core::DoorbellPage>> pages_;
  std::vector<Bell> bells_;
};

/// Any thread.
class DoorbellPages {
 public:
  /// Doorbells that cannot be opened (their process is gone) are left out.
  std::shared_ptr<const Doorbells> doorbells_of(const std::vector<core::Route>& routes);

 private:
  std::shared_ptr<core::DoorbellPage> open(std::uint64_t id);

  std::mutex mutex_;
  std::map<std::uint64_t, std::weak_ptr<core::DoorbellPage>> pages_;
};

}  // namespace sft::shm
