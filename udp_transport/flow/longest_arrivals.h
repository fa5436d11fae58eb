// Keeps, for each address that sends flow marks, the length of the longest datagram that has recently come
// from it. The reports that answer the marks carry this length. All processes and ports at an address count
// together, because they share one path. The class uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/platform/ip_address.h"

namespace sft::udp {

class LongestArrivals {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::size_t addresses_max = 256;
  /// The length of a datagram is kept for at least one period and at most two periods. Senders use a
  /// report only as evidence about datagrams that they sent shortly before the flow mark: less than
  /// LengthMonitor::remembered_for, which is shorter than a period.
  static constexpr std::chrono::seconds period{1};
  /// An address that has sent no flow mark for this time is removed if the table is full and another address
  /// comes.
  static constexpr std::chrono::seconds kept_for{10};

  LongestArrivals() { addresses_.reserve(addresses_max); }

  /// Notes a datagram. Does nothing if no flow mark has come from that address yet.
  void note(const core::IpAddress& from, std::size_t bytes, Time now) {
    if (last_ >= addresses_.size() || addresses_[last_].ip != from) {
      const auto found = std::ranges::find(addresses_, from, &Address::ip);
      if (found == addresses_.end()) return;
      last_ = static_cast<std::size_t>(found - addresses_.begin());
    }
    Address& address = addresses_[last_];
    address.forget_old(now);
    address.present = std::max(address.present, static_cast<std::uint32_t>(bytes));
  }

  /// Notes a flow mark, whose length counts like that of other datagrams. Returns the length of the longest
  /// recent datagram from the address; 0 if the address was not known.
  std::uint32_t answer(const core::IpAddress& from, std::size_t mark_length, Time now) {
    const auto found = std::ranges::find(addresses_, from, &Address::ip);
    if (found == addresses_.end()) {
      if (addresses_.size() == addresses_max)
        std::erase_if(addresses_, [&](const Address& one) { return now - one.marked_at > kept_for; });
      if (addresses_.size() < addresses_max)
        addresses_.push_back({.ip = from, .begun = now, .marked_at = now});
      return 0;
    }
    found->marked_at = now;
    note(from, mark_length, now);
    return std::max(found->present, found->former);
  }

 private:
  struct Address {
    core::IpAddress ip;
    Time begun{};  ///< start of the present period
    Time marked_at{};
    /// Length of the longest datagram of this period and of the previous one.
    std::uint32_t present = 0, former = 0;

    void forget_old(Time now) {
      if (now - begun < period) return;
      former = now - begun < 2 * period ? present : 0;
      present = 0;
      begun = now;
    }
  };

  std::vector<Address> addresses_;
  std::size_t last_ = 0;  ///< index of the address of the latest datagram
};

}  // namespace sft::udp
