// The two ports of one selection of a subscriber, and the intake of what they bring, behind one mutex. Any
// thread, except where something is marked as the agent's. The mutex is held for a short time, never over a
// system call, a copy of a sample or a callback.
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
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

class SubscriberPorts {
 public:
  /// A sample that was taken.
  struct Next : Taken {
    /// The request that the sample is delivered under: one of those before if it has parts that only that one
    /// asked for. Null if nobody asks.
    std::shared_ptr<const Asked> asked{};
    /// The sample has to be copied, reduced to what is asked for, and then reported to copied(). It stays as
    /// it is if the request has no plan.
    bool is_copied = false;
  };

  /// `reports_asked`: each sample comes with its request, also if it is delivered as it is.
  SubscriberPorts(const Intake::Options& options, std::shared_ptr<const Asked> asked, bool reports_asked)
      : reports_asked_(reports_asked), intake_(options) {
    requests(std::move(asked), 1);
  }

  /// The next sample in order; empty if there is none.
  Next take();
  /// The newest sample; those before it are passed over.
  Next take_latest();
  bool available() { return next_origin().has_value(); }
  /// The origin of the next sample in order; none if there is no sample.
  std::optional<SampleOrigin> next_origin();
  /// See Intake.
  void copied(const SampleInfo& info, bool is_delivered);
  std::shared_ptr<NetworkReader> network();

  void ask(std::uint32_t min_period_us);
  std::uint32_t min_period_us();
  Selection requested();
  SubscriberStatus status();

  // The agent's.
  /// Null: the subscriber has none any more.
  void set_memory(std::shared_ptr<BorrowingReader> port);
  /// The memory was lost, and so was the port there. What has come by it can still be taken.
  void lose_memory();
  /// Lets go of the lost port if nothing waits in it, or also what waits. True if there is none any more.
  bool release_lost_memory(bool also_if_some_wait);
  void set_network(std::shared_ptr<NetworkReader> port);
  void hears(const std::vector<Hearing>& hearing);
  /// The request that is in force from now on, and its number. Null: the same request with another number.
  void requests(std::shared_ptr<const Asked> asked, std::uint64_t sequence);
  /// No sample under an earlier request is under way any more. Some may wait to be taken.
  void forget_former_conditions();
  /// Returns true if status() differs by it.
  bool keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive);
  /// The connection to that writer was set up anew, because nothing arrived by it.
  void restarted(EndpointId writer);
  /// True if a sample was held back since this was called last.
  bool take_held_back();
  /// Grows whenever samples of some writer were lost.
  std::uint64_t losses();
  std::uint64_t held_too_many();
  /// Changes whenever a sample of that writer has arrived.
  std::uint64_t arrivals(EndpointId writer);
  /// The samples of that writer that have come and that were lost.
  Account::OfReader account_of(EndpointId writer);

 private:
  /// Counts of ports that no gap between samples shows.
  struct Counts {
    std::uint64_t lost = 0;
    std::uint64_t discarded = 0;
    std::uint64_t held_too_many = 0;
    void add(const ReaderPort& port);
    void add(const MemoryInlet::Port& port);
  };

  /// True if intake_ can deliver a sample.
  bool find_next() SFT_REQUIRES(mutex_);
  Next next() SFT_REQUIRES(mutex_);
  /// Says under which request the sample is delivered.
  void settle(Next& next) SFT_REQUIRES(mutex_);
  Counts counts() const SFT_REQUIRES(mutex_);
  /// Called after samples may have been taken. The port may make a system call.
  void notify_room() SFT_EXCLUDES(mutex_);

  static constexpr std::size_t earlier_max = 64;  ///< requests under which samples may still come

  const bool reports_asked_;
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  Intake intake_ SFT_GUARDED_BY(mutex_);
  MemoryInlet memory_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<NetworkReader> network_ SFT_GUARDED_BY(mutex_);
  Counts of_former_ports_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<const Asked> asked_ SFT_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<const Asked>> earlier_ SFT_GUARDED_BY(mutex_);  ///< the latest first
  std::uint64_t requests_ SFT_GUARDED_BY(mutex_) = 1;
  /// Of what comes, nothing is of an earlier request any more: only samples that wait to be taken.
  std::optional<AskedGates::Number> in_force_ SFT_GUARDED_BY(mutex_);
  /// Some request had parts, which may have to be taken out of samples that are still under way.
  bool takes_parts_ SFT_GUARDED_BY(mutex_) = false;
  /// Some writer in shared memory waits for room. Written with the mutex held, read without it.
  std::atomic<bool> writers_wait_{false};
};

}  // namespace sft::core
