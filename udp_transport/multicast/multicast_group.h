// Processes to which one writer sends one copy together: to a multicast group, under the union of their
// masks (multicast.md). The members of a group never change. Another set of members needs another group,
// with another number.
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
    std::shared_ptr<Lane> lane;  ///< the member's own lane, which is used until the member has reported
    /// The channel to the member; null: the member is served by best effort.
    std::shared_ptr<Channel> channel;
    friend bool operator==(const Member&, const Member&) = default;
  };
  struct Name {
    std::uint32_t writer = 0;
    std::uint32_t number = 0;   ///< the writer's number for the group, never used again
    std::uint32_t address = 0;  ///< IPv4 address, host byte order
  };

  /// `lane` leads to the group. Members' reports come to the port `report_port`.
  static std::shared_ptr<MulticastGroup> make(const Name& name, std::shared_ptr<Lane> lane,
                                              std::vector<Member> members, std::uint16_t report_port);

  const Name& name() const { return name_; }
  const std::vector<Member>& members() const { return members_; }
  const std::shared_ptr<Lane>& lane() const { return lane_; }
  /// Returns the group's lane in a form that keeps the group alive, too. The group has to be notified of
  /// samples that have left the lane.
  static std::shared_ptr<Lane> lane_of(const std::shared_ptr<MulticastGroup>& group);

  // The following functions are for the thread that sends: the publisher's thread, or the sending thread in
  // its place.

  /// Returns the ordinal in the group for the next sample. The caller sends that sample now.
  std::uint64_t next_ordinal(Time now) noexcept;
  /// Returns true if samples that are sent to the group arrive at that member at present.
  bool hears(std::size_t member) const noexcept { return hears_[member].load(std::memory_order_relaxed); }
  /// Notes the place of a sample in the member's channel.
  void placed(std::size_t member, std::uint64_t ordinal, std::uint64_t in_channel) noexcept;
  /// Returns true if the own socket of at least one member has answered, and is not silent. So a real
  /// receiver wants the samples.
  bool is_answered() const noexcept;
  /// Returns true if nothing may be sent to the group any more.
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }
  /// The members without a channel: one flag says if some of them receive the group, the other if some do
  /// not.
  struct BestEffort {
    bool some_hear = false;
    bool some_do_not = false;
  };
  BestEffort best_effort() const noexcept;

  /// Notes that a sample for the group has departed, or is lost. Any thread may call this.
  [[nodiscard]] Wake note_departed(const Job& job, bool lost) noexcept;
  /// Notes that a sample in the lane has departed. The sending thread calls this, so it needs no wake.
  void departed(const Job& job, bool lost) noexcept override { static_cast<void>(note_departed(job, lost)); }
  /// Returns the members, including those that do not receive the group.
  std::span<const Destination* const> receivers() const noexcept override { return receivers_; }
  void hear(const GroupReport& report, Time now);
  /// Returns the index of the member with that name in reports; empty if there is none.
  std::optional<std::size_t> member_named(std::uint32_t name) const;
  std::string state_of(std::size_t member) const;
  /// Called by the thread that takes answers, when a member requests parts of samples in its channel again.
  /// If other members have requested the same sample, it is sent to the group again, and its parts are
  /// removed from `ack`.
  [[nodiscard]] Wake take_over_repairs(std::size_t member, Ack& ack, Time now);

  // The following functions are for the agent's thread.

  struct Offer {
    std::size_t member = 0;
    GroupOffer offer;
  };
  /// Returns the offers that are due now.
  std::vector<Offer> offers(Time now);
  /// Returns the probe that is due now, if any. Members that were offered the group a moment ago have
  /// joined by now, and can receive the probe before the next sample.
  std::optional<GroupProbe> probe(Time now);
  /// Returns when a probe will be due; Time::max() if none is planned.
  Time next_probe() const;
  /// Returns the members that multicast seems not to reach.
  std::vector<const Destination*> given_up() const;
  /// Returns the farewell, which notifies a member that it is not in the group any more.
  GroupOffer farewell(std::size_t member) const;

 private:
  MulticastGroup(const Name& name, std::shared_ptr<Lane> lane, std::vector<Member> members,
                 std::uint16_t report_port);

  /// A sample that was requested again recently.
  struct Asked {
    std::uint64_t ordinal = 0;
    std::uint64_t by = 0;  ///< bit set of the members that requested it; more than 64 share bits
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
  /// The names of members in their reports. They are random, so that an attacker who alters a member's
  /// report cannot guess the name of another member.
  const std::vector<std::uint32_t> member_names_;
  std::unique_ptr<std::atomic<bool>[]> hears_;  ///< by member: true if the member receives the group

  mutable core::Mutex mutex_;  ///< locked only for a few instructions
  std::vector<GroupMembership> memberships_ SFT_GUARDED_BY(mutex_);
  /// By member: the ordinal in its channel minus the ordinal in the group; empty: nothing was sent yet.
  std::vector<std::optional<std::int64_t>> ahead_ SFT_GUARDED_BY(mutex_);
  /// The ordinal before that of the first sample. It is random, so that a forged probe cannot cause a
  /// report that the writer accepts.
  const std::uint64_t first_probed_;
  std::uint64_t last_ordinal_ SFT_GUARDED_BY(mutex_);
  ProbeSchedule probes_ SFT_GUARDED_BY(mutex_);
  std::atomic<bool> broken_{false};
  std::array<Asked, 64> asked_{};  ///< used by the thread that takes answers
  std::size_t next_asked_ = 0;
};

/// The groups of all writers of a transport. Finds the group of a report, or of a channel. Any thread may
/// call the functions.
class GroupRegistry {
 public:
  void add(const std::shared_ptr<MulticastGroup>& group);
  std::shared_ptr<MulticastGroup> find(std::uint32_t writer, std::uint32_t number);
  struct OfChannel {
    std::shared_ptr<MulticastGroup> group;  ///< the group of the channel; null: the channel is in no group
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
