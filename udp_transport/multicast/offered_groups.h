// The multicast groups of one writer that this process was offered (multicast.md): where the samples of a
// group belong in its channel, and what to report. Pure: calls and times in, answers out.
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

  /// An offer of a group that is known already, but says something else, replaces the one before when it
  /// comes twice. One without an address takes that group back and those with lower numbers, if nothing of
  /// these was heard lately, or when it comes twice. True if the address is to be joined anew: nothing of
  /// that group has come for so long that a switch may not know of the membership, or not any more.
  bool hear(const GroupOffer& offer, const SocketAddress& from, Time now);

  /// A first datagram came by a group: gives it its place in the channel, if it has one there. False if that
  /// group was not offered, or with another channel than the one that is followed, if any is: the sample
  /// comes otherwise then. However many samples of the group come, one offer alone says that they are of that
  /// channel. They must not count as so many claims: the writer itself may be naming the true channel.
  bool place(FirstHeader& first, Time now, const ChannelMonitor* channels = nullptr);

  /// A probe came by a group: that counts as if a sample had come. Ignored if that group was not offered.
  void hear(const GroupProbe& probe, Time now);
  bool knows(std::uint32_t group) const;

  /// Notes that a sample of that group has no position in the channel any more and had never arrived before,
  /// or that it has one. If the former goes on, the offer was not what its writer sent, and the writer is
  /// asked to repeat it.
  void note(std::uint32_t group, bool misplaced);

  /// Calls `send(address, report)` for each that is due. After place().
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
  /// Something of a group has come that is not over yet, as far as this process knows.
  bool were_heard() const {
    return std::ranges::any_of(groups_, [](const Offered& g) { return g.heard != 0; });
  }
  /// Adds those that are to be joined.
  void addresses(std::vector<std::uint32_t>& to) const;

 private:
  /// Returns true if an offer that contradicts what is known came before.
  bool comes_again(const GroupOffer& offer);
  void take_back(const GroupOffer& offer, Time now);

  struct Offered;
  bool in_use(const Offered& group, Time now) const {
    return group.heard != 0 && now - group.alive_at < used_for;
  }
  bool is_over(const Offered& group, Time now) const;
  bool make_room(Time now);
  /// The numbers of a writer's groups turn over.
  static bool is_before(const GroupOffer& a, const GroupOffer& b) {
    return static_cast<std::int32_t>(a.group - b.group) < 0;
  }
  void part_from(const Offered& group);
  void came(Offered& group, std::uint64_t ordinal, Time now);
  void note(Offered& group, bool misplaced);

  struct Offered {
    GroupOffer offer;
    SocketAddress report_to;
    Time alive_at;  ///< joined, or heard
    std::uint64_t heard = 0;
    Time reported_at{};
    bool due = false;
    bool is_unconfirmed = false;  ///< an offer that says something else came last, or much was misplaced
    std::uint32_t misplaced = 0;  ///< datagrams in a row
  };
  static constexpr std::uint32_t misplaced_max = 8;
  /// The present one, and those of which something may still be under way.
  static constexpr std::size_t groups_max = 4;
  /// A switch knows of who joins sooner.
  static constexpr std::chrono::milliseconds silence_max{250};
  /// A group that was heard within that time does not make room for another one, unless it is over.
  static constexpr std::chrono::milliseconds used_for{500};
  /// A writer whose readers come one after another makes several groups in that time. Each is over when the
  /// next one is heard, but something of it may still be under way for so long.
  static constexpr std::chrono::milliseconds under_way_for{100};
  /// A group that is in use was replaced or taken back, and its writer is told so. The writer knows whether
  /// it has said that. If not, it offers the group again at once.
  struct Parting {
    SocketAddress to;
    GroupReport report;
  };
  std::vector<Parting> partings_;
  std::vector<Offered> groups_;  ///< the newest last
  GroupOffer unconfirmed_;       ///< an offer that contradicts what is known
  bool due_ = false;
};

}  // namespace sft::udp
