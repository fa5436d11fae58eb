// Processes that one writer sends one copy to, by a multicast group, under the union of their masks
// (multicast.md). Who is in it never changes: others make another group, with another number.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/sync/mutex.h"
#include "udp_transport/multicast/group_membership.h"
#include "udp_transport/multicast/probe_schedule.h"
#include "udp_transport/reliable/channel.h"
#include "udp_transport/reliable/lane.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class MulticastGroup final : public LaneListener {
 public:
  using Time = GroupMembership::Time;

  struct Member {
    std::shared_ptr<Lane> lane;        ///< its own way, as long as it has not reported
    std::shared_ptr<Channel> channel;  ///< null: it is sent by best effort
    friend bool operator==(const Member&, const Member&) = default;
  };
  struct Name {
    std::uint32_t writer = 0;
    std::uint32_t number = 0;   ///< the writer's, never used again
    std::uint32_t address = 0;  ///< IPv4, host byte order
  };

  /// `lane` leads to the group. `report_port` is where reports come in.
  static std::shared_ptr<MulticastGroup> make(const Name& name, std::shared_ptr<Lane> lane,
                                              std::vector<Member> members, std::uint16_t report_port);

  const Name& name() const { return name_; }
  const std::vector<Member>& members() const { return members_; }
  const std::shared_ptr<Lane>& lane() const { return lane_; }
  /// Keeps the group, too, for who sends what waits there: it has to be told what has left.
  static std::shared_ptr<Lane> lane_of(const std::shared_ptr<MulticastGroup>& group);

  // Used by the thread that sends: the publisher's, or the sending thread in its place.

  /// The next sample is sent to it, at this place.
  std::uint64_t next_ordinal(Time now) noexcept;
  /// True if samples that are sent now come to that member.
  bool hears(std::size_t member) const noexcept { return hears_[member].load(std::memory_order_relaxed); }
  /// Notes the place of a sample in the member's channel.
  void placed(std::size_t member, std::uint64_t ordinal, std::uint64_t in_channel) noexcept;
  /// A member's own socket has answered, and is not silent: somebody wants what is sent.
  bool is_answered() const noexcept;
  /// Nothing may be sent to it any more.
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }
  /// The members without a channel: whether some hear the group, and whether some do not.
  struct BestEffort {
    bool some_hear = false;
    bool some_do_not = false;
  };
  BestEffort best_effort() const noexcept;

  /// Any thread. A sample that was sent to the group has departed, or is lost.
  [[nodiscard]] Wake note_departed(const Job& job, bool lost) noexcept;
  /// The same, of a sample in the lane, which the sending thread looks after.
  void departed(const Job& job, bool lost) noexcept override { static_cast<void>(note_departed(job, lost)); }
  /// The members, whether they hear the group or not.
  std::span<const Destination* const> receivers() const noexcept override { return receivers_; }
  void hear(const GroupReport& report, Time now);
  /// The one that calls itself so in reports; empty if none does.
  std::optional<std::size_t> member_named(std::uint32_t name) const;
  std::string state_of(std::size_t member) const;
  /// The thread that hears answers: a member asks for parts of samples in its channel. Takes those out that
  /// are sent to the group again, since others asked for the same.
  [[nodiscard]] Wake take_over_repairs(std::size_t member, Ack& ack, Time now);

  // The agent's thread.

  struct Offer {
    std::size_t member = 0;
    GroupOffer offer;
  };
  /// The offers that are due now.
  std::vector<Offer> offers(Time now);
  /// The probe that is due now, if any: members that were offered the group a moment ago have joined by now,
  /// and can hear it before the next sample.
  std::optional<GroupProbe> probe(Time now);
  /// Returns when probe() will have one; Time::max() if no probe is planned.
  Time next_probe() const;
  /// The members that hear nothing of the group.
  std::vector<const Destination*> given_up() const;
  /// Tells a member that it is in the group no more.
  GroupOffer farewell(std::size_t member) const;

 private:
  MulticastGroup(const Name& name, std::shared_ptr<Lane> lane, std::vector<Member> members,
                 std::uint16_t report_port);

  /// A sample that was asked for lately.
  struct Asked {
    std::uint64_t ordinal = 0;
    std::uint64_t by = 0;  ///< a bit for each member; of more than 64, some share one
    bool sent_again = false;
    Time at{};
  };
  bool is_taken_over(std::size_t member, std::uint64_t in_channel, Time now, Wake& wake);
  bool send_again(std::size_t member, std::uint64_t in_channel, Wake& wake);

  const Name name_;
  const std::shared_ptr<Lane> lane_;
  const std::vector<Member> members_;
  const std::vector<const Destination*> receivers_;  ///< the members' destinations
  const std::uint16_t report_port_;
  /// Members call themselves by these names. Somebody who alters a report of one does not guess another name.
  const std::vector<std::uint32_t> member_names_;
  std::unique_ptr<std::atomic<bool>[]> hears_;  ///< for each member

  mutable core::Mutex mutex_;  ///< held for a few instructions
  std::vector<GroupMembership> memberships_ SFT_GUARDED_BY(mutex_);
  /// For each member: its channel's ordinals are ahead of the group's by so many; empty: nothing was sent
  /// yet.
  std::vector<std::optional<std::int64_t>> ahead_ SFT_GUARDED_BY(mutex_);
  /// One below that of the first sample. Whoever has heard nothing of the group cannot guess it, so that a
  /// forged probe makes nobody report what the writer believes.
  const std::uint64_t first_probed_;
  std::uint64_t last_ordinal_ SFT_GUARDED_BY(mutex_);
  ProbeSchedule probes_ SFT_GUARDED_BY(mutex_);
  std::atomic<bool> broken_{false};
  std::array<Asked, 64> asked_{};  ///< used by the thread that hears answers
  std::size_t next_asked_ = 0;
};

/// The groups of all writers of a transport, so that each report finds its group. Any thread.
class GroupRegistry {
 public:
  void add(const std::shared_ptr<MulticastGroup>& group);
  std::shared_ptr<MulticastGroup> find(std::uint32_t writer, std::uint32_t number);
  struct OfChannel {
    std::shared_ptr<MulticastGroup> group;  ///< null: in none
    std::size_t member = 0;
  };
  OfChannel of_channel(std::uint32_t writer, std::uint32_t channel);

 private:
  struct Membership {
    std::weak_ptr<MulticastGroup> group;
    std::size_t member = 0;
  };
  core::Mutex mutex_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::weak_ptr<MulticastGroup>> known_
      SFT_GUARDED_BY(mutex_);
  std::map<std::pair<std::uint32_t, std::uint32_t>, Membership> by_channel_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
