// The multicast groups of one writer that were offered to this process (multicast.md). The class determines
// the ordinals of a group's samples in the channel, and the reports that are due. Uses no clock, thread or
// I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/reliable/channel_monitor.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class OfferedGroups {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Processes an offer. An offer that contradicts a known group replaces that group only when it comes
  /// twice. An offer without an address withdraws the group and all groups with lower numbers, if none of
  /// them was in use recently or when the offer comes twice. Returns true if the group has to be joined
  /// again: no datagram of the group has come for so long that a switch may have discarded the membership.
  bool hear(const GroupOffer& offer, const SocketAddress& from, Time now);

  /// Writes the ordinal in the channel into the first datagram of a sample that came by a group, if the
  /// sample is in the channel. Returns false if that group was not offered, or was offered for a different
  /// channel than the followed one. Then the sample comes by unicast. All ordinals of a group depend on a
  /// single offer, which may be wrong. So samples of a group, however many, are no evidence for the number
  /// of the channel.
  bool place(FirstHeader& first, Time now, const ChannelMonitor* channels = nullptr);

  /// Processes a probe that came by a group. A probe counts like a sample. It is ignored if that group was
  /// not offered.
  void hear(const GroupProbe& probe, Time now);
  bool knows(std::uint32_t group) const;

  /// Notes that a sample of that group has begun to arrive. `misplaced` is true if the channel does not wait
  /// for a sample with that ordinal. After several misplaced samples in a row, the offer must have been
  /// wrong, and the writer is asked to repeat it.
  void note(std::uint32_t group, bool misplaced);

  /// Calls `send(address, report)` for each report that is due. Must be called after place().
  template <class Send>
  void report(const Send& send) {
    if (!due_) return;
    due_ = false;
    for (const Parting& parting : std::exchange(partings_, {})) send(parting.to, parting.report);
    for (Offered& group : groups_) {
      if (!group.due) continue;
      group.due = false;
      const std::uint64_t heard = group.misplaced < misplaced_max ? group.heard : 0;
      send(group.report_to, GroupReport{group.offer.writer, group.offer.group, group.offer.member, heard});
    }
  }

  bool due() const { return due_; }
  bool empty() const { return groups_.empty(); }
  /// Returns true if samples of a group have come that has not ended, as far as this process knows.
  bool were_heard() const {
    return std::ranges::any_of(groups_, [](const Offered& g) { return g.heard != 0; });
  }
  /// Adds to `to` the addresses of the groups that should be joined.
  void addresses(std::vector<std::uint32_t>& to) const;

 private:
  /// Notes a contradicting offer. Returns true if the previous contradicting offer was equal to it.
  bool comes_again(const GroupOffer& offer);
  void take_back(const GroupOffer& offer, Time now);

  struct Offered;
  bool in_use(const Offered& group, Time now) const {
    return group.heard != 0 && now - group.alive_at < used_for;
  }
  bool is_over(const Offered& group, Time now) const;
  bool make_room(Time now);
  /// Compares numbers of groups by their difference, because the numbers of a writer's groups wrap around.
  static bool is_before(const GroupOffer& a, const GroupOffer& b) {
    return static_cast<std::int32_t>(a.group - b.group) < 0;
  }
  void part_from(const Offered& group);
  void came(Offered& group, std::uint64_t ordinal, Time now);
  void note(Offered& group, bool misplaced);

  struct Offered {
    GroupOffer offer;
    SocketAddress report_to;
    Time alive_at;  ///< time when the group was joined, or when its last sample came
    std::uint64_t heard = 0;
    Time reported_at{};
    bool due = false;
    /// True if the latest offer contradicted this group's offer, or many samples were misplaced.
    bool is_unconfirmed = false;
    std::uint32_t misplaced = 0;  ///< number of misplaced datagrams in a row
  };
  static constexpr std::uint32_t misplaced_max = 8;
  /// The maximum number of groups of a writer: the present group, and earlier groups of which samples may
  /// still be under way.
  static constexpr std::size_t groups_max = 4;
  /// If no datagram of a group has come for longer than this, switches may have lost the membership. A
  /// switch registers a new member in less time.
  static constexpr std::chrono::milliseconds silence_max{250};
  /// A group of which a sample has come within this time is not replaced by a new group, unless it has
  /// ended.
  static constexpr std::chrono::milliseconds used_for{500};
  /// Samples of a group that has ended may be under way for this time. If the readers of a writer come one
  /// after another, the writer makes several groups in that time. Each of these groups has ended when a
  /// sample of the next one is received.
  static constexpr std::chrono::milliseconds under_way_for{100};
  /// A message to the writer that a group in use was replaced or withdrawn. If the writer did not do that,
  /// it offers the group again at once.
  struct Parting {
    SocketAddress to;
    GroupReport report;
  };
  std::vector<Parting> partings_;
  std::vector<Offered> groups_;  ///< the newest group is last
  GroupOffer unconfirmed_;       ///< the latest offer that contradicts the known groups
  bool due_ = false;
};

}  // namespace sft::udp
