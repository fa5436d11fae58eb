// The ports of one selection of a subscriber, and the intake of their samples, protected by one mutex.
// Any thread may call its functions, except for those marked as the agent's. The mutex is held for a short
// time, never during a system call, a copy of a sample or a callback.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "core/subscribe/asked.h"
#include "core/subscribe/intake.h"
#include "core/subscribe/memory_inlet.h"
#include "core/subscribe/vanilla_inlet.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// Larger than usual: it has a function for each fact that the agent sets or reads under the one mutex.
class SubscriberPorts {
 public:
  /// A sample that was taken.
  struct Next : Taken {
    /// The request for which the sample is delivered. It is an earlier one if the sample has what only that
    /// one asked for. Null if the request is not needed.
    std::shared_ptr<const Asked> asked{};
    /// True: the sample has to be copied, reduced to what is asked for, and then reported to copied(). It is
    /// not reduced if the request has no plan.
    bool is_copied = false;
  };

  /// `reports_asked`: each sample comes with its request, even if it is delivered as it is.
  SubscriberPorts(const Intake::Options& options, std::shared_ptr<const Asked> asked, bool reports_asked)
      : reports_asked_(reports_asked), intake_(options) {
    requests(std::move(asked), 1);
  }

  /// Returns the next sample in order; empty if there is none.
  Next take();
  /// Returns the newest sample, and skips those before it.
  Next take_latest();
  bool available() { return next_origin().has_value(); }
  /// Returns the origin of the next sample in order; nothing if there is no sample.
  std::optional<SampleOrigin> next_origin();
  /// See Intake.
  void copied(const SampleInfo& info, bool is_delivered);
  std::shared_ptr<NetworkReader> network();

  void ask(std::uint32_t min_period_us);
  std::uint32_t min_period_us();
  Selection requested();
  SubscriberStatus status();

  // The agent's thread.
  /// Sets the port to shared memory; null: the subscriber has none any more.
  void set_memory(std::shared_ptr<BorrowingReader> port);
  /// Called when the memory was lost, and the port with it. Samples that have come by it can still be taken.
  void lose_memory();
  /// Destroys the lost port if no sample waits in it, or if `also_if_some_wait` is true. Returns true if
  /// there is no lost port any more.
  bool release_lost_memory(bool also_if_some_wait);
  void set_network(std::shared_ptr<NetworkReader> port);
  /// Sets the inlet for samples of unmodified DDS writers. Whoever puts a sample in rings the subscriber's
  /// doorbell.
  void set_vanilla(std::shared_ptr<VanillaInlet> inlet);
  void hears(const std::vector<Hearing>& hearing);
  /// Sets the request that is in force from now on, and its number. Null: only the number changes.
  void requests(std::shared_ptr<const Asked> asked, std::uint64_t sequence);
  /// Called when no sample under an earlier request is under way any more. Some may still wait to be taken.
  void forget_former_conditions();
  /// Sets what status() says of a writer's promises. Returns true if that changes.
  bool keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive);
  /// Counts that the connection to that writer was set up anew because nothing arrived by it.
  void restarted(EndpointId writer);
  /// Returns true if a sample was held back since the last call.
  bool take_held_back();
  /// Returns the number of lost samples of all writers.
  std::uint64_t losses();
  std::uint64_t held_too_many();
  /// Returns a number that changes whenever a sample of that writer arrives.
  std::uint64_t arrivals(EndpointId writer);
  /// Returns how many samples of that writer were received and lost.
  Account::OfReader account_of(EndpointId writer);

 private:
  /// Counts of ports that no gap between samples shows.
  struct Counts {
    std::uint64_t lost = 0;
    std::uint64_t discarded = 0;
    std::uint64_t held_too_many = 0;
    void add(const ReaderPort::Counters& counters);
    void add(const ReaderPort& port) { add(port.counters()); }
    void add(const MemoryInlet::Port& port);
  };

  /// Fills the intake and carries out its decisions. Returns true if it can deliver a sample.
  bool find_next() SFT_REQUIRES(mutex_);
  Next next() SFT_REQUIRES(mutex_);
  /// Determines for which request the sample is delivered.
  void settle(Next& next) SFT_REQUIRES(mutex_);
  Counts counts() const SFT_REQUIRES(mutex_);
  /// Wakes writers that wait for room. Called after samples may have been taken. It may make a system call.
  void notify_room() SFT_EXCLUDES(mutex_);

  static constexpr std::size_t earlier_max = 64;  ///< the most earlier requests that are kept

  const bool reports_asked_;
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  Intake intake_ SFT_GUARDED_BY(mutex_);
  MemoryInlet memory_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<NetworkReader> network_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<VanillaInlet> vanilla_ SFT_GUARDED_BY(mutex_);  ///< null until it is needed
  Counts of_former_ports_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<const Asked> asked_ SFT_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<const Asked>> earlier_ SFT_GUARDED_BY(mutex_);  ///< the latest first
  std::uint64_t requests_ SFT_GUARDED_BY(mutex_) = 1;
  /// If set: no more samples of requests before this one arrive, but some may wait to be taken.
  std::optional<AskedGates::Number> in_force_ SFT_GUARDED_BY(mutex_);
  /// True once a request had parts, since samples that are under way may have to be reduced to them.
  bool takes_parts_ SFT_GUARDED_BY(mutex_) = false;
  /// True if a writer in shared memory waits for room. Written with the mutex held, read without it.
  std::atomic<bool> writers_wait_{false};
};

}  // namespace sft::core
