// The thread that wakes readers for the publishers of a node: where several sleep, a publisher that made a
// futex call for each would return late. It is started when first needed, and publishers that find it does
// not run do all of it themselves.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "core/platform/doorbell.h"
#include "core/platform/thread.h"

namespace sft::shm {

/// Something to be done by the waker. That it is const lets it be part of what does not change.
class Errand {
 public:
  /// On the waker's thread, at least once after each Waker::run().
  virtual void run() const noexcept = 0;

 protected:
  ~Errand() = default;

 private:
  friend class Waker;
  mutable std::atomic<bool> listed_{false};
  mutable std::shared_ptr<const Errand> self_;  ///< while it is listed
  mutable const Errand* next_ = nullptr;
};

class Waker {
 public:
  explicit Waker(core::ThreadSpec spec = "sft-wake") : spec_(std::move(spec)) {}
  /// Runs what is still listed.
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  /// Starts the thread if it does not run; where the system gives none, the next call tries again. Any
  /// thread.
  void start();

  /// Has it run, and returns at once: takes no lock and no memory. False if there is no thread for it. Any
  /// thread, for one errand one at a time.
  bool run(const std::shared_ptr<const Errand>& errand) noexcept;

 private:
  void serve();
  void run_all() noexcept;

  const core::ThreadSpec spec_;
  core::Doorbell bell_;
  std::atomic<const Errand*> listed_{nullptr};  ///< the latest first
  std::atomic<bool> running_{false};
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;  // guards what follows
  std::thread thread_;
};

}  // namespace sft::shm
