// The writer's end of a reliable channel. It holds samples, sends their datagrams as fast as the flow window
// allows, and sends them again if an ack requests them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "tests/simulation/udp/loss_account.h"
#include "tests/simulation/udp/network.h"
#include "tests/simulation/udp/scenario.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::simulation {

class ChannelSender {
 public:
  using Size = udp::ResendWindow::Size;

  /// Opens the first channel. The arguments must outlive this object.
  ChannelSender(const Scenario& scenario, Random& random, Network& network, LossAccount& loss_account);

  /// Opens another channel. After that nothing is sent in the former one.
  void open();
  std::uint32_t number() const { return number_; }
  const udp::ResendWindow& window() const { return *window_; }

  udp::ResendWindow::Kept keep(const udp::JobHandle& job, bool elsewhere = false);
  /// Records that the multicast group has sent a sample.
  void departed(std::uint64_t ordinal, Time now) { window_->departed(ordinal, now); }
  /// Called when there may be datagrams to send.
  void wake(Time now);
  void send(Time now);
  /// Handles a received ack or report of the flow.
  void hear(const Bytes& bytes, Time now);
  /// Returns the time at which send() is due next.
  Time next(Time now) const;

 private:
  /// A sample, or a part of a sample, that is being cut into datagrams.
  struct Sending {
    udp::ResendWindow::Piece piece;
    udp::Fragmenter fragments;
  };

  void send_some(Size size, Time now);
  bool begin_piece(std::optional<Sending>& sending, Size size, Time now);
  bool may_send(Size size, Time now);
  void send_datagram(Sending& sending, Time now);
  void end_piece(Sending& sending, Time now);
  void send_mark(Time now);
  void send_heartbeat(Time now);

  const Scenario& scenario_;
  Random& random_;
  Network& network_;
  LossAccount& loss_account_;
  std::uint32_t number_ = 0;
  std::unique_ptr<udp::ResendWindow> window_;
  std::unique_ptr<udp::FlowWindow> flow_;
  std::uint64_t oldest_kept_ = 1;  ///< the lowest ordinal that is still held
  std::optional<Sending> sending_[2];
  Time send_at_ = start_time;
};

}  // namespace sft::simulation
