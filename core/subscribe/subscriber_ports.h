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
#include "core/subscribe/vanilla_inlet.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// Larger than usual: it has a function for each fact that the agent sets or reads under the one mutex.
class SubscriberPorts {
 public:
  /// A sample that was taken.
  struct Next : Taken {
    /// The request for which the sample is delivered. It is an earlier request if the sample has fields or
    /// parts that only the earlier one asked for. Null if the request is not needed.
    std::shared_ptr<const Asked> asked{};
    /// True: the sample has to be copied, reduced to the request, and then reported to copied(). It is not
    /// reduced if the request has no plan.
    bool is_copied = false;
  };

  /// `reports_asked` means that each sample is returned with its request, even if it is delivered unchanged.
  SubscriberPorts(const Intake::Options& options, std::shared_ptr<const Asked> asked, bool reports_asked)
      : reports_asked_(reports_asked), intake_(options) {
    requests(std::move(asked), 1);
  }

  /// Returns the next sample in order. Its handle is empty if there is none.
  Next take();
  /// Returns the newest sample, and skips the samples before it.
  Next take_latest();
  bool available() { return next_origin().has_value(); }
  /// Returns the origin of the next sample in order, or nothing if there is no sample.
  std::optional<SampleOrigin> next_origin();
  /// See Intake.
  void copied(const SampleInfo& info, bool is_delivered);
  std::shared_ptr<NetworkReader> network();

  void ask(std::uint32_t min_period_us);
  std::uint32_t min_period_us();
  Selection requested();
  SubscriberStatus status();

  // The functions for the agent's thread.
  /// Sets the port to shared memory. Null: the subscriber has none any more.
  void set_memory(std::shared_ptr<BorrowingReader> port);
  /// Called when the memory, and thus the port, was lost. Samples that have arrived by the port can still be
  /// taken.
  void lose_memory();
  /// Destroys the lost port if no sample waits in it, or if `also_if_some_wait` is true. Returns true if
  /// there is no lost port afterwards.
  bool release_lost_memory(bool also_if_some_wait);
  void set_network(std::shared_ptr<NetworkReader> port);
  /// Sets the inlet for samples of unmodified DDS writers. The thread that puts a sample in rings the
  /// subscriber's doorbell.
  void set_vanilla(std::shared_ptr<VanillaInlet> inlet);
  void hears(const std::vector<Hearing>& hearing);
  /// Sets the request that is in force from now on, and its number. Null: only the number changes.
  void requests(std::shared_ptr<const Asked> asked, std::uint64_t sequence);
  /// Called when no sample of an earlier request is under way any more. Some may still wait to be taken.
  void forget_former_conditions();
  /// Sets the missed deadlines and the liveliness of a writer that status() reports. Returns true if the
  /// status changes.
  bool keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive);
  /// Counts a restart of the connection to that writer, which was set up anew because nothing arrived.
  void restarted(EndpointId writer);
  /// Returns true if a sample was held back since the last call.
  bool take_held_back();
  /// Returns the number of lost samples of all writers.
  std::uint64_t losses();
  std::uint64_t held_too_many();
  /// Returns a number that changes whenever a sample of that writer arrives.
  std::uint64_t arrivals(EndpointId writer);
  /// Returns the numbers of samples of that writer that were received and lost.
  DomainSnapshot::Received account_of(EndpointId writer);

 private:
  /// Counts of the ports, of samples that cause no gap between sequences.
  struct Counts {
    std::uint64_t lost = 0;
    std::uint64_t discarded = 0;
    std::uint64_t held_too_many = 0;
    void add(const ReaderPort::Counters& counters);
    void add(const ReaderPort& port) { add(port.counters()); }
    void add(const std::shared_ptr<BorrowingReader>& port);
  };

  /// Calls `take` with the port whose memory was lost, and then with the present one, until a sample comes.
  template <class Take>
  SampleHandle take_from_memory(Take take) SFT_REQUIRES(mutex_);
  /// Returns true if a sample waits in shared memory, even a sample that cannot be taken because max_held
  /// samples are held.
  bool some_wait_in_memory() const SFT_REQUIRES(mutex_);
  /// Fills the intake and carries out its decisions. Returns true if the intake can deliver a sample.
  bool find_next() SFT_REQUIRES(mutex_);
  Next next() SFT_REQUIRES(mutex_);
  /// Determines the request for which the sample is delivered.
  void settle(Next& next) SFT_REQUIRES(mutex_);
  Counts counts() const SFT_REQUIRES(mutex_);
  /// Wakes writers that wait for room. Called after samples may have been taken. The function may make a
  /// system call.
  void notify_room() SFT_EXCLUDES(mutex_);

  static constexpr std::size_t earlier_max = 64;  ///< the most earlier requests that are kept

  const bool reports_asked_;
  Mutex mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints) SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  Intake intake_ SFT_GUARDED_BY(mutex_);
  // The port to shared memory, and the former port whose memory was lost. Null if there is no such port. The
  // destructor of a port may return memory to the system, so it runs when the mutex is unlocked.
  std::shared_ptr<BorrowingReader> memory_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<BorrowingReader> lost_memory_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<NetworkReader> network_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<VanillaInlet> vanilla_ SFT_GUARDED_BY(mutex_);  ///< null until it is needed
  Counts of_former_ports_ SFT_GUARDED_BY(mutex_);
  std::shared_ptr<const Asked> asked_ SFT_GUARDED_BY(mutex_);
  /// The earlier requests, the latest first.
  std::vector<std::shared_ptr<const Asked>> earlier_ SFT_GUARDED_BY(mutex_);
  std::uint64_t requests_ SFT_GUARDED_BY(mutex_) = 1;
  /// If set: no samples of requests before this one arrive any more, but some may wait to be taken.
  std::optional<AskedGates::Number> in_force_ SFT_GUARDED_BY(mutex_);
  /// True if any request had parts. Then samples that are under way may have to be reduced to these parts.
  bool takes_parts_ SFT_GUARDED_BY(mutex_) = false;
  /// True: a writer in shared memory waits for room. Written with the mutex held, read without it.
  std::atomic<bool> writers_wait_{false};
};

}  // namespace sft::core
