// One subscriber without its message type: brings together what its ports receive, in the order of each
// writer, counts what is missing, and wakes or calls whoever waits.
//
// take(), take_latest() and wait() are called by any thread; what is the agent's is marked so; arrived() by
// threads of transports, dispatch() by these and the dispatcher.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/platform/doorbell.h"
#include "core/platform/poll_handle.h"
#include "core/report/event_sink.h"
#include "core/seam/transport.h"
#include "core/subscribe/recorder.h"
#include "core/subscribe/remote_copy.h"
#include "core/subscribe/sequence_account.h"
#include "sft/detail/untyped.h"

namespace sft::core {

class SubscriberCore final : public ArrivalListener {
 public:
  struct Spec {
    EndpointId id = 0;
    std::string topic;
    const TypeSupport* type = nullptr;
    detail::untyped::Requirement requirement;
    SubscriberOptions options;
    detail::untyped::Callback callback;        ///< empty: samples are taken
    std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null where it is static
    std::uint32_t min_period_us = 0;           ///< of options.max_rate_hz
    std::function<void()>
        rate_changed{};  ///< any thread: posts that min_period_us() is to be asked, and returns
    std::shared_ptr<BufferPool>
        as_remote{};  ///< not null: what comes in shared memory is copied to it, as asked for
    std::unique_ptr<PollHandle> poll_handle{};  ///< null: it has no file descriptor
    /// How long a sample in shared memory waits for an earlier one that went by UDP: far longer than that
    /// takes within a host. But it may be lost, and nobody should wait long for that.
    std::chrono::nanoseconds diverted_patience = std::chrono::milliseconds(100);
    std::uint32_t shm_depth = 0;  ///< samples of a writer that shared memory keeps; 0: options.depth
  };

  /// `bell` is what is rung when samples arrive; `recorder` is null unless the requirement is recorded.
  SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder);

  detail::untyped::Sample take();
  detail::untyped::Sample take_latest();
  bool wait(std::chrono::nanoseconds timeout);
  bool available();
  /// -1 if it has none.
  int file_descriptor() const { return spec_.poll_handle ? spec_.poll_handle->descriptor() : -1; }
  Result<void> set_max_rate_hz(double max_rate_hz);
  /// Of the maximum rate that was set last.
  std::uint32_t min_period_us();

  // Subscribers with a callback or a file descriptor: whoever sleeps on their doorbell for them.

  /// Whether there is something that nobody is dispatching, or that the file descriptor does not tell.
  bool waits_for_dispatch();
  /// Calls back for all there is, or tells the file descriptor. Returns at once if a call is under way on
  /// another thread: that one goes on.
  void dispatch();

  /// Calls back on the spot, which is quickest, unless callbacks were seen to take long lately: then it
  /// leaves that to the dispatcher, so that the transport can go on.
  void arrived() noexcept override;

  /// Whether a callback may be running. Once closed, and when it is not, none will any more.
  bool is_called_back() const { return pending_.load() != 0; }
  /// After it returns no callback runs any more, except for one in which it is called itself.
  void close();

  SubscriberStatus status();
  Requirements requirements();
  /// Whether this thread is within a callback of some subscriber.
  static bool in_callback() noexcept;

  const TypeSupport& type() const { return *spec_.type; }
  const Spec& spec() const { return spec_; }
  bool has_callback() const { return static_cast<bool>(spec_.callback); }
  EventSink& events() { return events_; }

  // The agent's.
  /// Wakes who waits, if a sample was held back; called now and then, so that none is for long.
  void look_again();
  void set_port(TransportKind kind, std::shared_ptr<ReaderPort> port);
  /// For status(): what is heard at present, and the mask and number of the request in force.
  void hears(const std::vector<Hearing>& hearing);
  void requests(const FieldMask& mask, std::uint64_t sequence);
  /// Whether status() differs by it.
  bool keeps_promises(EndpointId writer, std::uint64_t deadlines_missed, bool alive);
  /// The connection to that writer was set up anew, since nothing arrived by it.
  void restarted(EndpointId writer);
  /// Differs from what it was whenever samples of some writer were lost meanwhile.
  std::uint64_t losses() const { return losses_.load(std::memory_order_relaxed); }
  std::uint64_t held_too_many();
  /// Differs from what it was whenever a sample of that writer has arrived meanwhile.
  std::uint64_t arrivals(EndpointId writer);
  /// What has come of that writer.
  Account::OfReader account_of(EndpointId writer);

 private:
  using Clock = std::chrono::steady_clock;
  using Now = Clock::time_point;

  struct Heard {  ///< per writer
    EndpointId writer = 0;
    SequenceAccount account;
    bool by_udp = false;  ///< the last that was entered came so
    std::uint64_t received = 0;
    std::uint64_t lost = 0;
    std::uint64_t withheld = 0;
    std::uint64_t lost_untold = 0;  ///< of these, not yet told with a sample
    std::uint64_t expired = 0;
    std::int64_t since_ns = 0;     ///< when it was looked for first
    std::int64_t lifespan_ns = 0;  ///< that the writer gives its samples; 0: no end
    std::uint64_t deadlines_missed = 0;
    std::uint64_t restarts = 0;
    bool alive = true;
  };
  struct Inlet {
    std::shared_ptr<ReaderPort> port;
    SampleHandle next;  ///< taken from the port, not yet from us
  };

  struct Next {
    SampleHandle sample;
    SampleInfo info;
    std::shared_ptr<const detail::ProjectionPlan>
        asked;  ///< not null: it is to have no more than that, and not counted as received yet
  };

  // Inlets: the ports, by TransportKind, and what was taken from shared memory out of turn.
  static constexpr std::size_t out_of_turn = 2;

  enum class Caller : std::uint8_t { dispatcher, transport };

  void hear(const std::vector<Hearing>& hearing);
  bool fill_inlets();
  Inlet* find_next();
  Numbered numbered(const Inlet& inlet) const;
  void enter(Heard& from, const Numbered& sample, TransportKind by);
  static bool is_expired(const Heard& from, const Numbered& sample);
  Inlet* oldest_inlet();
  Inlet* next_inlet();
  bool follows(const Inlet& inlet);
  Inlet& in_turn(Inlet& udp);
  bool waits(const Inlet& inlet);
  TransportKind transport_of(const Inlet& inlet) const;
  Heard& heard(EndpointId writer);
  void forget_the_gone();
  std::uint64_t sum_of_held_too_many() const;
  Next next();
  Next newest();
  template <class Choose>
  detail::untyped::Sample take(Choose choose);
  void settle_descriptor();
  bool wait_until(std::chrono::steady_clock::time_point deadline);
  void sleep_until(std::chrono::steady_clock::time_point deadline);
  void ring();
  std::shared_ptr<ReaderPort> port(TransportKind kind);
  std::shared_ptr<ReaderPort> udp_port() { return port(TransportKind::udp); }
  void tell_of_room();
  std::uint32_t depth_by(TransportKind kind) const;
  bool as_remote(Next& next);
  detail::untyped::Sample wrap(Next next);
  void dispatch(Caller caller);
  bool call_back_for_all(Caller caller);
  Now call_back(detail::untyped::Sample sample, Now before);

  const Spec spec_;
  Doorbell& bell_;
  const std::shared_ptr<Recorder> recorder_;
  std::mutex remote_mutex_;           // apart from mutex_, which must not be held while samples are copied
  std::optional<RemoteCopy> remote_;  ///< of whoever takes, one at a time
  EventSink events_;

  std::mutex mutex_;  // never held over a system call or a callback
  std::array<Inlet, 3> inlets_;
  bool holds_back_ = false;  ///< a sample, since somebody looked for one
  std::vector<Heard> heard_;
  Heard gone_;                          ///< sums of writers that were forgotten
  std::uint64_t discarded_before_ = 0;  ///< by ports that are gone
  std::uint64_t held_too_many_before_ = 0;
  std::atomic<std::uint64_t> losses_{0};   ///< written with the mutex held
  std::atomic<bool> writers_wait_{false};  ///< some writer in shared memory waits for room; likewise
  std::vector<WriterStatus> writers_;
  FieldMask requested_;
  std::shared_ptr<const detail::ProjectionPlan>
      asked_;  ///< the same, where samples are to look as on another host
  std::uint64_t requests_ = 1;
  std::uint32_t min_period_us_;  ///< asked for

  std::atomic<bool> spins_{true};  ///< not after a wait in vain: that costs a node without traffic nothing

  // All sequentially consistent: waits_for_dispatch() of one thread against the end of dispatch() on another.
  std::atomic<std::uint32_t> pending_{
      0};  ///< arrivals not yet dispatched; whoever raises it from 0 dispatches
  std::atomic<bool> closed_{false};
  std::atomic<bool> is_slow_{false};  ///< a callback took long, and not enough quick ones came since then
  int quick_in_a_row_ = 0;            ///< of whoever dispatches
  std::atomic<std::thread::id> dispatching_{};
};

}  // namespace sft::core
