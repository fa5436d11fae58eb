#include "udp_transport/flow/path_mtu.h"

#include <algorithm>
#include <array>

namespace sft::udp {

namespace {
/// The usual maximum sizes of packets in bytes, ascending: radio links, tunnels within tunnels, the minimum
/// of IPv6, mobile networks, tunnels of overlay networks, PPPoE, Ethernet, FDDI, and jumbo frames.
constexpr std::array<std::size_t, 9> packets{1000, 1200, 1280, 1400, 1450, 1492, 1500, 4352, 9000};
constexpr std::size_t nearly_everywhere = 1280;  ///< nearly every path carries packets of this size
}  // namespace

PathMtu::PathMtu(std::size_t headers, std::size_t shortest, std::size_t kernel_says)
    : headers_(headers), shortest_(shortest), ceiling_(std::max(kernel_says, shortest)), bytes_(ceiling_) {}

/// If the kernel's value has changed, the path has changed. Then everything that was learnt about the former
/// path is discarded.
void PathMtu::kernel_says(std::size_t bytes) {
  bytes = std::max(bytes, shortest_);
  if (bytes == ceiling_) return;
  ceiling_ = bytes_ = bytes;
  proven_ = 0;
  too_long_ = none;
  retry_after_ = retry_pause;
  losses_ = 0;
  is_limited_ = false;
}

/// Ignores a report about datagrams that were sent before the present length was set, because it is no
/// evidence about that length.
void PathMtu::lost(std::size_t length, Time now) {
  if (length > bytes_) return;
  if (losses_++ == 0) {
    first_loss_ = now;
    lost_length_ = none;
  }
  lost_length_ = std::min(lost_length_, length);
  if (losses_ >= losses_max && now - first_loss_ >= timeout) shorten(now);
}

/// Shortens datagrams to a length that has been found to work. If there is none, it first tries a length
/// that nearly every path carries, and then the length that every path carries.
void PathMtu::shorten(Time now) {
  losses_ = 0;
  if (bytes_ == shortest_) return;
  too_long_ = bytes_;
  is_limited_ = true;
  const std::size_t base = std::max(packet(nearly_everywhere), shortest_);
  if (proven_ != 0 && proven_ < bytes_) {
    bytes_ = proven_;
  } else {
    bytes_ = bytes_ > base ? base : shortest_;
    proven_ = 0;
  }
  next_try_ = now + retry_after_;
  retry_after_ = std::min<Time::duration>(2 * retry_after_, retry_pause_max);
}

/// Takes the length of a datagram that has arrived. A datagram that is shorter than the lost ones does not
/// disprove their loss. A datagram that is shorter than the present length does not prove that length.
void PathMtu::arrived(std::size_t length, Time now) {
  if (length >= lost_length_) losses_ = 0;
  if (length < bytes_ || bytes_ <= proven_) return;
  proven_ = bytes_;
  is_limited_ = is_limited_ && bytes_ < ceiling_;
  next_try_ = now + (next_longer() < too_long_ ? Time::duration(search_pause) : retry_after_);
}

/// Tries a longer length only if datagrams of the present length have arrived. Otherwise the loss of longer
/// datagrams would not be noticed.
void PathMtu::look_after(Time now) {
  if (bytes_ >= ceiling_ || proven_ < bytes_ || now < next_try_) return;
  // The path may carry longer datagrams by now, so all lengths are possible again.
  if (next_longer() >= too_long_) too_long_ = none;
  bytes_ = next_longer();
}

std::size_t PathMtu::next_longer() const {
  const auto* step = std::ranges::find_if(packets, [&](std::size_t bytes) { return packet(bytes) > bytes_; });
  return step == packets.end() ? ceiling_ : std::min(packet(*step), ceiling_);
}

}  // namespace sft::udp
