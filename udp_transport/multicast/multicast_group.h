// Processes that one writer sends one copy to, by a multicast group, under the union of their masks
// (multicast.md). The members of a group never change. Other members need another group, with another
// number.
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
    std::shared_ptr<Lane> lane;        ///< the member's own lane, until it has reported
    std::shared_ptr<Channel> channel;  ///< null: the member is served by best effort
    friend bool operator==(const Member&, const Member&) = default;
  };
  struct Name {
    std::uint32_t writer = 0;
    std::uint32_t number = 0;   ///< the writer's number for the group, never used again
    std::uint32_t address = 0;  ///< IPv4 address, host byte order
  };

  /// `lane` leads to the group. `report_port` is the port that reports come to.
  static std::shared_ptr<MulticastGroup> make(const Name& name, std::shared_ptr<Lane> lane,
                                              std::vector<Member> members, std::uint16_t report_port);

  const Name& name() const { return name_; }
  const std::vector<Member>& members() const { return members_; }
  const std::shared_ptr<Lane>& lane() const { return lane_; }
  /// Returns the lane so that it keeps the group alive, too, because the group has to be told which samples
  /// have left.
  static std::shared_ptr<Lane> lane_of(const std::shared_ptr<MulticastGroup>& group);

  // Used by the thread that sends: the publisher's thread, or the sending thread in its place.

  /// Returns the ordinal in the group of the next sample, which is sent now.
  std::uint64_t next_ordinal(Time now) noexcept;
  /// Returns true if samples that are sent to the group now arrive at that member.
  bool hears(std::size_t member) const noexcept { return hears_[member].load(std::memory_order_relaxed); }
  /// Notes the place of a sample in the member's channel.
  void placed(std::size_t member, std::uint64_t ordinal, std::uint64_t in_channel) noexcept;
  /// Returns true if a member's own socket has answered, and is not silent, so that a real receiver wants
  /// what is sent.
  bool is_answered() const noexcept;
  /// Returns true if nothing may be sent to the group any more.
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }
  /// The members without a channel: whether some of them hear the group, and whether some do not.
  struct BestEffort {
    bool some_hear = false;
    bool some_do_not = false;
  };
  BestEffort best_effort() const noexcept;

  /// Notes that a sample that was sent to the group has departed, or is lost. Any thread.
  [[nodiscard]] Wake note_departed(const Job& job, bool lost) noexcept;
  /// Notes that a sample in the lane has departed. The sending thread calls this, so it needs no wake.
  void departed(const Job& job, bool lost) noexcept override { static_cast<void>(note_departed(job, lost)); }
  /// Returns the members, whether they hear the group or not.
  std::span<const Destination* const> receivers() const noexcept override { return receivers_; }
  void hear(const GroupReport& report, Time now);
  /// Returns the index of the member with that name in reports; empty if there is none.
  std::optional<std::size_t> member_named(std::uint32_t name) const;
  std::string state_of(std::size_t member) const;
  /// Called by the thread that takes answers: a member asks for parts of samples in its channel. Removes
  /// those parts from `ack` whose samples are sent to the group again, since other members asked for them,
  /// too.
  [[nodiscard]] Wake take_over_repairs(std::size_t member, Ack& ack, Time now);

  // The agent's thread.

  struct Offer {
    std::size_t member = 0;
    GroupOffer offer;
  };
  /// Returns the offers that are due now.
  std::vector<Offer> offers(Time now);
  /// Returns the probe that is due now, if any. Members that were offered the group a moment ago have
  /// joined by now, and can hear the probe before the next sample.
  std::optional<GroupProbe> probe(Time now);
  /// Returns when a probe will be due; Time::max() if none is planned.
  Time next_probe() const;
  /// Returns the members that multicast seems not to reach.
  std::vector<const Destination*> given_up() const;
  /// Returns the message that tells a member that it is not in the group any more.
  GroupOffer farewell(std::size_t member) const;

 private:
  MulticastGroup(const Name& name, std::shared_ptr<Lane> lane, std::vector<Member> members,
                 std::uint16_t report_port);

  /// A sample that was asked for recently.
  struct Asked {
    std::uint64_t ordinal = 0;
    std::uint64_t by = 0;  ///< bit set of the members that asked; more than 64 share bits
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
  /// The names of members in their reports. Nobody who alters a member's report can guess another member's
  /// name.
  const std::vector<std::uint32_t> member_names_;
  std::unique_ptr<std::atomic<bool>[]> hears_;  ///< one flag for each member

  mutable core::Mutex mutex_;  ///< held for a few instructions
  std::vector<GroupMembership> memberships_ SFT_GUARDED_BY(mutex_);
  /// For each member: its channel's ordinal minus the group's; empty: nothing was sent yet.
  std::vector<std::optional<std::int64_t>> ahead_ SFT_GUARDED_BY(mutex_);
  /// The ordinal before that of the first sample. It is random, so that a forged probe cannot lead to a
  /// report that the writer believes.
  const std::uint64_t first_probed_;
  std::uint64_t last_ordinal_ SFT_GUARDED_BY(mutex_);
  ProbeSchedule probes_ SFT_GUARDED_BY(mutex_);
  std::atomic<bool> broken_{false};
  std::array<Asked, 64> asked_{};  ///< used by the thread that takes answers
  std::size_t next_asked_ = 0;
};

/// The groups of all writers of a transport. Finds the group of a report, or of a channel. Any thread.
class GroupRegistry {
 public:
  void add(const std::shared_ptr<MulticastGroup>& group);
  std::shared_ptr<MulticastGroup> find(std::uint32_t writer, std::uint32_t number);
  struct OfChannel {
    std::shared_ptr<MulticastGroup> group;  ///< null: the channel is in no group
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
