// A multicast group: processes to which one writer sends one common copy of each sample, with the union of
// their masks (multicast.md). The members of a group never change. A different set of members gets a new
// group with a new number.
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
    /// The lane to the member alone, which is used while the member does not receive the group.
    std::shared_ptr<Lane> lane;
    /// The channel to the member; null: the member is served by best effort.
    std::shared_ptr<Channel> channel;
    friend bool operator==(const Member&, const Member&) = default;
  };
  struct Name {
    std::uint32_t writer = 0;
    std::uint32_t number = 0;   ///< the number of the group, unique for the writer
    std::uint32_t address = 0;  ///< IPv4 address, host byte order
  };

  /// `lane` sends to the group. Members send their reports to our port `report_port`.
  static std::shared_ptr<MulticastGroup> make(const Name& name, std::shared_ptr<Lane> lane,
                                              std::vector<Member> members, std::uint16_t report_port);

  const Name& name() const { return name_; }
  const std::vector<Member>& members() const { return members_; }
  const std::shared_ptr<Lane>& lane() const { return lane_; }
  /// Returns a pointer to the group's lane that also keeps the group alive. That is necessary because the
  /// lane notifies the group of sent samples.
  static std::shared_ptr<Lane> lane_of(const std::shared_ptr<MulticastGroup>& group);

  // The following functions are for the thread that sends samples: the publisher's thread, or the sending
  // thread on its behalf.

  /// Returns the ordinal of the next sample in the group. The caller must send that sample now.
  std::uint64_t next_ordinal(Time now) noexcept;
  /// Returns true if samples that are sent to the group arrive at that member at present.
  bool hears(std::size_t member) const noexcept { return hears_[member].load(std::memory_order_relaxed); }
  /// Notes that the sample with the ordinal `ordinal` in the group has the ordinal `in_channel` in the
  /// member's channel.
  void placed(std::size_t member, std::uint64_t ordinal, std::uint64_t in_channel) noexcept;
  /// Returns true if the unicast socket of at least one member has answered and is not silent. This shows
  /// that a real receiver wants the samples.
  bool is_answered() const noexcept;
  /// Returns true if no sample may be sent to the group any more (placed()).
  bool broken() const noexcept { return broken_.load(std::memory_order_relaxed); }
  /// The state of the members without a channel: true if some of them receive the group, and true if some do
  /// not.
  struct BestEffort {
    bool some_hear = false;
    bool some_do_not = false;
  };
  BestEffort best_effort() const noexcept;

  /// Notes that a sample for the group was sent, or is lost. Any thread may call this.
  [[nodiscard]] Wake note_departed(const Job& job, bool lost) noexcept;
  /// Notes that a sample in the lane was sent. The sending thread calls this, so it need not be woken.
  void departed(const Job& job, bool lost) noexcept override { static_cast<void>(note_departed(job, lost)); }
  /// Returns the destinations of all members, including members that do not receive the group.
  std::span<const Destination* const> receivers() const noexcept override { return receivers_; }
  void hear(const GroupReport& report, Time now);
  /// Returns the index of the member that uses that name in reports; empty if there is none.
  std::optional<std::size_t> member_named(std::uint32_t name) const;
  std::string state_of(std::size_t member) const;
  /// Handles the ack of a member that requests parts of samples again. If other members have requested the
  /// same sample, sends that sample to the group again, and removes its parts from `ack`. Called by the
  /// thread that processes answers.
  [[nodiscard]] Wake take_over_repairs(std::size_t member, Ack& ack, Time now);

  // The following functions are for the agent's thread.

  struct Offer {
    std::size_t member = 0;
    GroupOffer offer;
  };
  /// Returns the offers that are due now.
  std::vector<Offer> offers(Time now);
  /// Returns the probe that is due now, if any. Members to which the group was offered shortly before have
  /// joined by now, and can report by the probe before the next sample comes.
  std::optional<GroupProbe> probe(Time now);
  /// Returns the time of the next probe; Time::max() if none is planned.
  Time next_probe() const;
  /// Returns the destinations of members that multicast seems not to reach.
  std::vector<const Destination*> given_up() const;
  /// Returns the farewell, which notifies a member that it is not in the group any more.
  GroupOffer farewell(std::size_t member) const;

 private:
  MulticastGroup(const Name& name, std::shared_ptr<Lane> lane, std::vector<Member> members,
                 std::uint16_t report_port);

  /// A sample that was requested again recently.
  struct Asked {
    std::uint64_t ordinal = 0;
    std::uint64_t by = 0;  ///< bit set of the members that requested it; the bit is the index modulo 64
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

  mutable core::Mutex mutex_;  ///< locked for a few instructions at a time
  std::vector<GroupMembership> memberships_ SFT_GUARDED_BY(mutex_);
  /// By member: the ordinal of a sample in its channel minus the ordinal in the group; empty: no sample was
  /// sent yet.
  std::vector<std::optional<std::int64_t>> ahead_ SFT_GUARDED_BY(mutex_);
  /// The ordinal in the probes before the first sample. It is random, so that a forged probe cannot cause a
  /// report that the writer accepts.
  const std::uint64_t first_probed_;
  std::uint64_t last_ordinal_ SFT_GUARDED_BY(mutex_);
  ProbeSchedule probes_ SFT_GUARDED_BY(mutex_);
  std::atomic<bool> broken_{false};
  std::array<Asked, 64> asked_{};  ///< used by the thread that processes answers
  std::size_t next_asked_ = 0;
};

/// The multicast groups of all writers of a transport. The class finds the group that a report names, or to
/// which a channel belongs. Any thread may call the functions.
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
