#include "core/discovery/own_records.h"

#include <algorithm>

namespace sft::core {

std::optional<OwnRecords::Change> OwnRecords::put(Role role, std::uint64_t owner, RecordKind kind,
                                                  std::vector<std::byte> body, Time now) {
  OfRole& of_role = of_role_[role];
  const RecordKey key{slot_of(of_role, owner), kind};
  const Record* const before = of_role.records.find(key);
  if (before != nullptr && !before->is_withdrawn() && *before->body == body) return std::nullopt;
  return enter(of_role, key, std::make_shared<const std::vector<std::byte>>(std::move(body)), now);
}

std::vector<OwnRecords::Change> OwnRecords::withdraw(Role role, std::uint64_t owner, Time now) {
  OfRole& of_role = of_role_[role];
  std::vector<Change> changes;
  const auto owned = of_role.slots.extract(owner);
  if (!owned) return changes;
  const std::uint32_t slot = owned.mapped();
  for (const RecordKind kind : {RecordKind::announcement, RecordKind::request, RecordKind::inquiry}) {
    const Record* const record = of_role.records.find({slot, kind});
    if (record != nullptr && !record->is_withdrawn())
      changes.push_back(enter(of_role, {slot, kind}, nullptr, now));
  }
  of_role.free.push_back(slot);
  return changes;
}

std::uint32_t OwnRecords::slot_of(OfRole& of_role, std::uint64_t owner) {
  const auto [owned, is_new] = of_role.slots.try_emplace(owner, 0);
  if (!is_new) return owned->second;
  if (of_role.free.empty()) return owned->second = of_role.slots_made++;
  owned->second = of_role.free.back();
  of_role.free.pop_back();
  return owned->second;
}

OwnRecords::Change OwnRecords::enter(OfRole& of_role, const RecordKey& key, RecordBody body, Time now) {
  const Record record{++revision_, std::move(body)};
  of_role.records.put(key, record);
  if (!changed_at_) changed_at_ = now;
  return {key, record};
}

Time OwnRecords::heartbeat_due() const {
  if (!given_at_) return Time{};
  if (changed_at_) return std::max(*changed_at_, *given_at_ + timing_.heartbeat_pause);
  return *given_at_ + (confirms_ ? timing_.heartbeat_pause : timing_.heartbeat_every);
}

bool OwnRecords::is_heartbeat_due(Time now) const {
  const auto early = changed_at_ ? std::chrono::milliseconds{} : timing_.heartbeat_every / 12;
  return now + early >= heartbeat_due();
}

void OwnRecords::heartbeat_given(Time now) {
  confirms_ = changed_at_.has_value();
  changed_at_.reset();
  given_at_ = now;
}

}  // namespace sft::core
