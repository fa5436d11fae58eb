#include "udp_transport/flow/receive_shares.h"

#include <algorithm>

#include "udp_transport/flow/flow_window.h"

namespace sft::udp {

ReceiveShares::ReceiveShares(std::size_t receive_buffer_bytes)
    : usable_bytes_(usable_bytes(receive_buffer_bytes)) {
  senders_.reserve(senders_max);
}

void ReceiveShares::find_and_count(const SocketAddress& from) {
  const auto found = std::ranges::find_if(senders_, [&](const Sender& known) { return known.from == from; });
  if (found == senders_.end()) return;
  ++found->came;
  last_ = static_cast<std::size_t>(found - senders_.begin());
}

auto ReceiveShares::of_address(const core::IpAddress& ip) const {
  return std::ranges::equal_range(senders_, ip, {}, [](const Sender& sender) { return sender.from.ip; });
}

std::size_t ReceiveShares::addresses() const {
  std::size_t n = 0;
  for (std::size_t i = 0; i < senders_.size(); ++i)
    n += i == 0 || senders_[i].from.ip != senders_[i - 1].from.ip ? 1 : 0;
  return n;
}

/// Returns the sender of the flow mark, and adds it if it is not known. Returns null if there are too many
/// senders. For a new sender, the number of datagrams that have arrived is not known. All of them count as
/// arrived, because the sender would otherwise regard the missing ones as lost. If a sender's marks come
/// from another port, its path has changed, and former arrivals do not count.
ReceiveShares::Sender* ReceiveShares::known_or_new(const FlowMark& mark, const SocketAddress& from) {
  const auto found = std::ranges::find_if(
      senders_, [&](const Sender& known) { return known.flow == mark.flow && known.from.ip == from.ip; });
  if (found == senders_.end()) {
    const auto neighbours = of_address(from.ip);
    if (senders_.size() == senders_max || neighbours.size() == of_one_address_max) return nullptr;
    return &*senders_.insert(neighbours.end(),
                             Sender{.from = from, .flow = mark.flow, .came = mark.datagrams});
  }
  if (found->from != from)
    *found = {.from = from, .flow = mark.flow, .came = mark.datagrams, .granted = found->granted};
  return &*found;
}

/// Grants the sender its share of the receive buffer, and returns that share in bytes. Until all other
/// senders have received reports with their new shares, this sender gets at most what their former shares
/// leave, but at least a quarter of its share.
std::size_t ReceiveShares::grant(Sender& sender) const {
  const std::size_t share = usable_bytes_ / addresses() / of_address(sender.from.ip).size();
  std::size_t left = usable_bytes_;
  for (const Sender& other : senders_) {
    if (&other != &sender) left -= std::min(left, other.granted);
  }
  return sender.granted = std::clamp(left, share / 4, share);
}

FlowReport ReceiveShares::answer(const FlowMark& mark, const SocketAddress& from, Time now) {
  std::erase_if(senders_, [&](const Sender& known) { return now - known.marked_at > at_rest_after; });
  Sender* sender = known_or_new(mark, from);
  if (sender != nullptr) sender->marked_at = now;
  const std::size_t share = sender == nullptr ? usable_bytes_ / (4 * senders_max) : grant(*sender);
  return {.flow = mark.flow,
          .position = mark.position,
          .window_bytes = static_cast<std::uint32_t>(std::min<std::size_t>(share, UINT32_MAX)),
          .datagrams = mark.datagrams,
          .came = sender == nullptr ? mark.datagrams : sender->came,
          .sent_at_ns = mark.sent_at_ns};
}

}  // namespace sft::udp
