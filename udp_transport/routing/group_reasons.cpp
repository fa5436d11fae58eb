#include "udp_transport/routing/group_reasons.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sft::udp {

void GroupReasons::set_readers(Readers readers, std::shared_ptr<BodySizes> sizes, bool several) {
  const core::Lock lock(mutex_);
  readers_ = std::move(readers);
  sizes_ = std::move(sizes);
  several_ = several;
}

void GroupReasons::set_groups(Groups groups) {
  const core::Lock lock(mutex_);
  groups_ = std::move(groups);
}

std::string GroupReasons::of(core::EndpointId reader) const {
  const core::Lock lock(mutex_);
  const auto known = readers_.find(reader);
  if (known == readers_.end()) return {};
  const Reader& one = known->second;
  if (!one.refusal.empty()) return "alone: " + one.refusal;
  for (const auto& group : groups_) {
    for (std::size_t i = 0; i < group->members().size(); ++i) {
      if (&group->members()[i].lane->destination() != one.to) continue;
      return "group " + core::format(core::IpAddress(group->name().address)) + " of " +
             std::to_string(group->members().size()) + unwanted(one, *group) + group->state_of(i);
    }
  }
  return several_ ? "alone: a group would put hardly fewer bytes on the wire"
                  : "alone: nobody else could be in a group with it";
}

std::string GroupReasons::unwanted(const Reader& reader, const MulticastGroup& group) const {
  FieldMask fields = reader.fields;
  for (const auto& [id, other] : readers_) {
    const auto is_there = [to = other.to](const auto& member) { return &member.lane->destination() == to; };
    if (std::ranges::any_of(group.members(), is_there)) fields |= other.fields;
  }
  if (sizes_ == nullptr || fields == reader.fields) return "";
  const double bytes = sizes_->bytes_of(fields) - sizes_->bytes_of(reader.fields);
  return ", which adds " + std::to_string(std::lround(bytes)) + " bytes to a sample that others asked for";
}

}  // namespace sft::udp
