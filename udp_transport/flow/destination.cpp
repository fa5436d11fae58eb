#include "udp_transport/flow/destination.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/platform/random_id.h"
#include "udp_transport/io/interfaces.h"

namespace sft::udp {

namespace {
FlowLimits flow_limits(const DestinationLimits& limits) {
  FlowLimits flow = limits.flow;
  flow.asks = limits.report_port != 0;
  return flow;
}

/// Returns the length of the longest datagram that the kernel sends to the address in one piece, but at most
/// the length in `limits`.
std::size_t ask_kernel(const SocketAddress& address, const DestinationLimits& limits) noexcept {
  return std::min<std::size_t>(datagram_bytes_to(address),
                               std::max(limits.datagram_bytes, datagram_bytes_min));
}

Destination::Change change_of(bool& before, bool now) {
  if (std::exchange(before, now) == now) return Destination::Change::none;
  return now ? Destination::Change::found : Destination::Change::over;
}
}  // namespace

Destination::Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
                         Connect connect, std::uint32_t channels, std::shared_ptr<UnprovenBudget> host)
    : limits_(limits),
      flow_(flow),
      channels_(channels),
      path_(address, ask_kernel(address, limits)),
      connections_(std::move(connect), address),
      window_(flow, flow_limits(limits), core::random_id(), std::move(host)) {}

Connection& Destination::connection_after(std::uint64_t position) {
  return position == 0 || window_.passed(position) ? connections_.small() : connections_.last_in_line();
}

void Destination::sent(const Connection& by, std::size_t bytes, std::size_t datagrams, std::size_t longest,
                       Time now) {
  const bool aside = &by != &connections_.last_in_line();
  if (const std::optional<FlowMark> due = window_.sent(bytes, datagrams, longest, now, aside))
    send(*due, now);
}

bool Destination::takes_control(Time now) {
  if (window_.takes_control(now)) return true;
  mark(now);
  return false;
}

void Destination::mark(Time now) {
  if (const std::optional<FlowMark> due = window_.await_room(now)) send(*due, now);
}

/// Sends a flow mark. If the mark cannot be sent, a later one replaces it.
void Destination::send(FlowMark mark, Time now) {
  mark.port = limits_.report_port;
  std::array<std::byte, mark_bytes> encoded;
  encode(mark, encoded.data());
  const iovec part{encoded.data(), encoded.size()};
  const OutgoingBatch batch{{&part, 1}, 0};
  if (connections_.last_in_line().try_send({&batch, 1}).refused) refused(now);
}

void Destination::note(SendOutcome outcome) noexcept {
  if (outcome == SendOutcome::no_segments) connections_.take_one_at_a_time();
  if (outcome == SendOutcome::too_long) {
    learn_from_kernel();
    // From now on the kernel divides single datagrams for this path, but no trains of datagrams.
    if (path_.datagram_bytes() == datagram_bytes_min) connections_.take_one_at_a_time();
  }
  if (outcome == SendOutcome::too_long || outcome == SendOutcome::failed) connections_.reconnect();
}

Destination::Heard Destination::hear(const FlowReport& report, const core::IpAddress& from, Time now) {
  const Heard heard = window_.hear(report, now);
  if (!heard.accepted) return heard;
  if (heard.control_was_withheld) moves_.fetch_add(1, std::memory_order_relaxed);
  if (!path_.is_at(from)) path_.learn(from);
  if (heard.lost_length != 0) {
    path_.were_lost(heard.lost_length, now);
  } else if (path_.length_is_uncertain()) {
    path_.arrived(report.longest, now);
  }
  return heard;
}

void Destination::move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept {
  if (!path_.move_to(address)) return;
  window_.move(core::random_id(), std::move(host));
  connections_.redirect(address);
  path_.measure_anew(address, ask_kernel(address, limits_));
  moves_.fetch_add(1, std::memory_order_relaxed);
}

void Destination::learn_from_kernel() noexcept {
  const SocketAddress asked = path_.address();
  path_.learn_length(asked, ask_kernel(asked, limits_));
}

void Destination::look_after(Time now, bool anew) noexcept {
  if (anew) connections_.reconnect();
  if (anew || now - kernel_asked_at_ >= kernel_is_asked_every) {
    kernel_asked_at_ = now;
    learn_from_kernel();
  }
  path_.look_after(now);
}

Destination::Change Destination::take_limit_change() noexcept {
  return change_of(was_limited_, path_.limited_to() != 0);
}

Destination::Change Destination::take_silence_change(Time now) noexcept {
  if (!window_.is_mute(now)) {
    mute_since_.reset();
  } else if (!mute_since_) {
    mute_since_ = now;
  }
  return change_of(was_silent_, mute_since_ && now - *mute_since_ >= silence_named_after);
}

}  // namespace sft::udp
