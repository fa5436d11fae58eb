// A FlowWindow for several threads. Publishers and the sending thread send, and any thread may process
// reports. A lock guards the window. Functions that are called for each sample do not take the lock.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/length_monitor.h"
#include "udp_transport/flow/unproven_budget.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class SharedFlowWindow {
 public:
  using Time = FlowWindow::Time;
  using Size = FlowWindow::Size;

  /// The arguments are those of FlowWindow.
  SharedFlowWindow(std::uint32_t flow, const FlowLimits& limits, std::uint64_t secret,
                   std::shared_ptr<UnprovenBudget> host = {});

  /// Returns the announced size of the remote socket's receive buffer; 0 if no size was announced.
  std::uint32_t receive_buffer_bytes() const { return receive_buffer_bytes_.load(std::memory_order_relaxed); }
  void announce(std::uint32_t receive_buffer_bytes);

  // FlowWindow has comments about the following functions.

  std::size_t room(Size size, Time now);
  std::size_t batch_bytes() const;
  Time next_ready(Time now) const;
  std::uint64_t position() const;
  bool passed(std::uint64_t position) const;
  /// Returns the shortest recent round trip; 0 if none is known.
  Time::duration round_trip() const;
  bool is_mute(Time now) const;
  /// Returns true if the receiver has reported, and was not silent at the last check.
  bool answers() const { return answers_.load(std::memory_order_relaxed); }

  /// Returns true if a heartbeat or an offer may be sent. If it is withheld, hear() returns that fact with
  /// the next accepted report (Heard::control_was_withheld).
  bool takes_control(Time now);
  /// Notes what was sent. Returns the flow mark that the caller has to send to the receiver now, if one is
  /// due. `longest` is the length of the longest datagram in bytes.
  [[nodiscard]] std::optional<FlowMark> sent(std::size_t bytes, std::size_t datagrams, std::size_t longest,
                                             Time now, bool aside);
  /// Notes that a sender waits until more bytes may be sent. Returns the flow mark that the caller has to
  /// send now, if one is due.
  [[nodiscard]] std::optional<FlowMark> await_room(Time now);

  struct Heard {
    bool accepted = false;
    bool goes_on = false;               ///< true if a sender that waited may continue now
    bool control_was_withheld = false;  ///< true if a heartbeat or offer was withheld and may be sent now
    std::size_t lost_length = 0;        ///< length of datagrams that have not arrived; 0: no loss is known
  };
  [[nodiscard]] Heard hear(const FlowReport& report, Time now);
  void lives(Time now);
  /// Notes that the receiver requests data again. A flow mark is then due soon, to find out if long
  /// datagrams arrive.
  void asked_again();
  void refused(Time now);
  void move(std::uint64_t secret, std::shared_ptr<UnprovenBudget> host);

 private:
  void note_answers(Time now) SFT_REQUIRES(mutex_);
  std::optional<FlowMark> mark(Time now) SFT_REQUIRES(mutex_);

  const bool asks_;
  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::queues)
      SFT_ACQUIRED_BEFORE(core::lock_order::facts);
  FlowWindow window_ SFT_GUARDED_BY(mutex_);
  LengthMonitor lengths_ SFT_GUARDED_BY(mutex_);
  bool control_withheld_ SFT_GUARDED_BY(mutex_) = false;
  std::atomic<bool> answers_;
  std::atomic<std::uint32_t> receive_buffer_bytes_{0};
};

}  // namespace sft::udp
