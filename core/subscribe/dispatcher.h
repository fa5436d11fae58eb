// The thread that calls back for samples in shared memory. It also calls back for samples that came by UDP if
// callbacks take long (short callbacks run on the receiving thread). It sleeps on one doorbell for all
// subscribers of a node that have callbacks.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/platform/thread.h"
#include "core/subscribe/subscriber_core.h"
#include "core/sync/mutex.h"

namespace sft::core {

class Dispatcher {
 public:
  /// `bell` must outlive the dispatcher.
  Dispatcher(Doorbell& bell, ThreadSpec spec) : bell_(bell), spec_(std::move(spec)) {}
  ~Dispatcher();
  Dispatcher(const Dispatcher&) = delete;
  Dispatcher& operator=(const Dispatcher&) = delete;

  /// Starts the thread. Must be called before the first add(). Does nothing if the thread was started before.
  /// Any thread.
  Result<void> start();

  void add(std::shared_ptr<SubscriberCore> subscriber);
  void remove(const SubscriberCore& subscriber);
  bool is_current_thread() const { return std::this_thread::get_id() == thread_id_.load(); }
  /// Returns true while the subscriber has its turn. Any thread.
  bool is_at(const SubscriberCore& subscriber) const { return in_turn_.load() == &subscriber; }

 private:
  using Subscribers = std::vector<std::shared_ptr<SubscriberCore>>;
  void run();
  std::shared_ptr<const Subscribers> subscribers() const;

  Doorbell& bell_;
  const ThreadSpec spec_;
  mutable Mutex mutex_;
  std::shared_ptr<const Subscribers> subscribers_ SFT_GUARDED_BY(mutex_) = std::make_shared<Subscribers>();
  std::atomic<bool> stopping_{false};
  std::atomic<std::thread::id> thread_id_{};
  std::atomic<const SubscriberCore*> in_turn_{nullptr};
  std::thread thread_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::core
