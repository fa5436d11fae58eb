#include "udp_transport/multicast/multicast_group.h"

#include <algorithm>
#include <utility>

#include "core/platform/random_id.h"

namespace sft::udp {

namespace {
/// If several members request the same sample within this time, they have probably lost the same datagram.
constexpr std::chrono::milliseconds asked_together{100};
/// The maximum size in bytes of samples that are sent to the group again. A larger sample misses only parts,
/// so each member gets just the parts that it requests.
constexpr std::size_t sent_again_bytes_max = std::size_t{16} << 10;
constexpr std::uint64_t first_probed_max = std::uint64_t{1} << 48;

/// Returns the names of members in reports. The upper half of a name is random, and the lower half is the
/// member's index.
std::vector<std::uint32_t> names_for(std::size_t members) {
  std::vector<std::uint32_t> names;
  for (std::size_t i = 0; i < members; ++i)
    names.push_back(static_cast<std::uint32_t>(core::random_id() << 16 | (i & 0xffff)));
  return names;
}

std::vector<const Destination*> destinations_of(const std::vector<MulticastGroup::Member>& members) {
  std::vector<const Destination*> destinations;
  for (const MulticastGroup::Member& member : members) destinations.push_back(&member.lane->destination());
  return destinations;
}
}  // namespace

std::shared_ptr<MulticastGroup> MulticastGroup::make(const Name& name, std::shared_ptr<Lane> lane,
                                                     std::vector<Member> members, std::uint16_t report_port) {
  std::shared_ptr<MulticastGroup> group(
      new MulticastGroup(name, std::move(lane), std::move(members), report_port));
  group->lane_->end().notify(group);
  return group;
}

MulticastGroup::MulticastGroup(const Name& name, std::shared_ptr<Lane> lane, std::vector<Member> members,
                               std::uint16_t report_port)
    : name_(name),
      lane_(std::move(lane)),
      members_(std::move(members)),
      receivers_(destinations_of(members_)),
      report_port_(report_port),
      member_names_(names_for(members_.size())),
      hears_(std::make_unique<std::atomic<bool>[]>(members_.size())),
      memberships_(members_.size()),
      ahead_(members_.size()),
      first_probed_(1 + core::random_id() % first_probed_max),
      last_ordinal_(first_probed_) {}

std::uint64_t MulticastGroup::next_ordinal(Time now) noexcept {
  const core::Lock lock(mutex_);
  for (GroupMembership& membership : memberships_) membership.sent(now);
  return ++last_ordinal_;
}

/// Notes the ordinals. If another sample has taken an ordinal of a member's channel (a sample of a late
/// reader's history can do that), all further samples would get wrong ordinals there. Then the group is
/// broken, and cannot be used any more.
void MulticastGroup::placed(std::size_t member, std::uint64_t ordinal, std::uint64_t in_channel) noexcept {
  const auto ahead = static_cast<std::int64_t>(in_channel - ordinal);
  {
    const core::Lock lock(mutex_);
    if (!ahead_[member]) ahead_[member] = ahead;
    if (*ahead_[member] == ahead) return;
    broken_.store(true, std::memory_order_relaxed);
    for (std::size_t i = 0; i < members_.size(); ++i) hears_[i].store(false, std::memory_order_relaxed);
  }
  // note_departed() does not find this sample, because the difference of its ordinals is not `ahead_`.
  static_cast<void>(members_[member].channel->departed(in_channel));
}

std::shared_ptr<Lane> MulticastGroup::lane_of(const std::shared_ptr<MulticastGroup>& group) {
  return {group, group->lane_.get()};
}

bool MulticastGroup::is_answered() const noexcept {
  return std::ranges::any_of(
      members_, [](const Member& member) { return member.lane->destination().window().answers(); });
}

MulticastGroup::BestEffort MulticastGroup::best_effort() const noexcept {
  BestEffort result;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i].channel == nullptr) (hears(i) ? result.some_hear : result.some_do_not) = true;
  }
  return result;
}

Wake MulticastGroup::note_departed(const Job& job, bool lost) noexcept {
  Wake wake = Wake::none;
  const std::uint64_t ordinal = job.first.group.ordinal;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& member = members_[i];
    if (member.channel == nullptr) {
      if (lost && hears(i)) member.lane->losses()->lost(job.first.total, job.whole_bytes);
      continue;
    }
    std::optional<std::int64_t> ahead;
    {
      const core::Lock lock(mutex_);
      ahead = ahead_[i];
    }
    if (ahead) wake = strongest(wake, member.channel->departed(ordinal + static_cast<std::uint64_t>(*ahead)));
  }
  return wake;
}

void MulticastGroup::hear(const GroupReport& report, Time now) {
  const std::optional<std::size_t> member = member_named(report.member);
  const core::Lock lock(mutex_);
  if (!member || report.heard > last_ordinal_ || broken()) return;
  if (report.heard != 0 && report.heard < first_probed_) return;
  GroupMembership& membership = memberships_[*member];
  if (report.heard == 0) {
    membership.refused(last_ordinal_, now);
  } else {
    membership.reported(report.heard, now);
  }
  hears_[*member].store(membership.hears(), std::memory_order_relaxed);
}

std::optional<std::size_t> MulticastGroup::member_named(std::uint32_t name) const {
  const std::size_t member = name & 0xffff;
  if (member >= member_names_.size() || member_names_[member] != name) return {};
  return member;
}

Wake MulticastGroup::take_over_repairs(std::size_t member, Ack& ack, Time now) {
  Wake wake = Wake::none;
  std::size_t remaining = 0;
  for (std::size_t i = 0; i < ack.missing_count; ++i) {
    const std::uint64_t in_channel = widen_sequence(ack.next, ack.missing[i].ordinal);
    if (!is_taken_over(member, in_channel, now, wake)) ack.missing[remaining++] = ack.missing[i];
  }
  ack.missing_count = remaining;
  return wake;
}

/// Returns true if the sample is sent to the group again. The first member that requests a sample gets its
/// own copy. A member that requests the sample once more also gets its own copy, because a copy to the group
/// may be lost again.
bool MulticastGroup::is_taken_over(std::size_t member, std::uint64_t in_channel, Time now, Wake& wake) {
  std::optional<std::int64_t> ahead;
  {
    const core::Lock lock(mutex_);
    ahead = ahead_[member];
  }
  if (!ahead || broken() || !hears(member)) return false;
  const std::uint64_t ordinal = in_channel - static_cast<std::uint64_t>(*ahead);
  const std::uint64_t bit = std::uint64_t{1} << member % 64;
  const auto asked = std::ranges::find_if(asked_, [&](const Asked& one) {
    return one.ordinal == ordinal && now - one.at < asked_together && one.ordinal != 0;
  });
  if (asked == asked_.end()) {
    asked_[next_asked_++ % asked_.size()] = {ordinal, bit, false, now};
    return false;
  }
  if ((std::exchange(asked->by, asked->by | bit) & bit) != 0) return false;
  if (!asked->sent_again) asked->sent_again = send_again(member, in_channel, wake);
  return asked->sent_again;
}

bool MulticastGroup::send_again(std::size_t member, std::uint64_t in_channel, Wake& wake) {
  JobHandle job = members_[member].channel->sent_elsewhere(in_channel);
  const bool is_ours = job && job->first.group.group == name_.number;
  if (!is_ours || job->first.total > sent_again_bytes_max || !lane_->has_room()) return false;
  wake = strongest(wake, lane_->post(std::move(job)).wake);
  return true;
}

std::string MulticastGroup::state_of(std::size_t member) const {
  return hears(member) ? "" : "; it has not reported any sample of the group yet, or no more";
}

std::vector<MulticastGroup::Offer> MulticastGroup::offers(Time now) {
  std::vector<Offer> due;
  const core::Lock lock(mutex_);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    GroupMembership& membership = memberships_[i];
    membership.look(now);
    if (!membership.hears()) hears_[i].store(false, std::memory_order_relaxed);
    const Channel* channel = members_[i].channel.get();
    const bool known = channel == nullptr || ahead_[i].has_value();
    if (!known || broken() || !membership.offer_due(now)) continue;
    GroupOffer offer = farewell(i);
    offer.address = name_.address;
    offer.channel = channel == nullptr ? 0 : channel->number();
    offer.ahead = channel == nullptr ? 0 : *ahead_[i];
    due.push_back({i, offer});
  }
  if (!due.empty()) probes_.offered(now);
  return due;
}

std::optional<GroupProbe> MulticastGroup::probe(Time now) {
  // This is determined before due() is called, which counts a probe as sent.
  const bool may_send = is_answered() && !broken();
  const core::Lock lock(mutex_);
  if (!probes_.due(now) || !may_send) return {};
  if (std::ranges::all_of(memberships_, &GroupMembership::hears)) {
    probes_.stop();
    return {};
  }
  return GroupProbe{name_.writer, name_.number, last_ordinal_};
}

MulticastGroup::Time MulticastGroup::next_probe() const {
  const core::Lock lock(mutex_);
  return probes_.next();
}

std::vector<const Destination*> MulticastGroup::given_up() const {
  std::vector<const Destination*> destinations;
  const core::Lock lock(mutex_);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (memberships_[i].given_up()) destinations.push_back(&members_[i].lane->destination());
  }
  return destinations;
}

GroupOffer MulticastGroup::farewell(std::size_t member) const {
  return {
      .writer = name_.writer, .group = name_.number, .member = member_names_[member], .port = report_port_};
}

void GroupRegistry::add(const std::shared_ptr<MulticastGroup>& group) {
  const core::Lock lock(mutex_);
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  std::erase_if(by_channel_, [](const auto& entry) { return entry.second.group.expired(); });
  known_[{group->name().writer, group->name().number}] = group;
  for (std::size_t i = 0; i < group->members().size(); ++i) {
    if (const Channel* channel = group->members()[i].channel.get())
      by_channel_[{group->name().writer, channel->number()}] = {group, i};
  }
}

std::shared_ptr<MulticastGroup> GroupRegistry::find(std::uint32_t writer, std::uint32_t number) {
  const core::Lock lock(mutex_);
  const auto known = known_.find({writer, number});
  return known == known_.end() ? nullptr : known->second.lock();
}

GroupRegistry::OfChannel GroupRegistry::of_channel(std::uint32_t writer, std::uint32_t channel) {
  const core::Lock lock(mutex_);
  const auto known = by_channel_.find({writer, channel});
  if (known == by_channel_.end()) return {};
  return {known->second.group.lock(), known->second.member};
}

}  // namespace sft::udp
