#include "udp_transport/routing/group_reasons.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

void GroupReasons::set_readers(Readers readers, std::shared_ptr<BodySizes> sizes) {
  const core::Lock lock(mutex_);
  readers_ = std::move(readers);
  sizes_ = std::move(sizes);
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
  if (!one.refusal.empty()) return alone(one);
  for (const auto& group : groups_) {
    for (std::size_t i = 0; i < group->members().size(); ++i) {
      if (&group->members()[i].lane->destination() != one.to) continue;
      const auto is_there = [&](const Destination* to) {
        return std::ranges::any_of(group->members(),
                                   [to](const auto& member) { return &member.lane->destination() == to; });
      };
      return "group " + core::format(core::IpAddress(group->name().address)) + " of " +
             std::to_string(group->members().size()) + unwanted(one, is_there) + group->state_of(i);
    }
  }
  return alone(one);
}

std::string GroupReasons::alone(const Reader& reader) const {
  std::string why = reader.refusal;
  if (why.empty()) {
    why = reader.has_company ? "a group would put hardly fewer bytes on the wire"
                             : "nobody else could be in a group with it";
  }
  if (!reader.shares) return "alone: " + why;
  const auto is_there = [&](const Destination* to) { return to == reader.to; };
  return "one copy for all readers of its process" + unwanted(reader, is_there) + "; in no group: " + why;
}

template <class IsThere>
std::string GroupReasons::unwanted(const Reader& reader, const IsThere& is_there) const {
  Selection sent = reader.asked;
  for (const auto& [id, other] : readers_) {
    if (is_there(other.to)) sent = one_copy(sent, other.asked);
  }
  if (sizes_ == nullptr || sent == reader.asked) return "";
  const double part_less = reader.part == nullptr ? 0 : reader.part->bytes_less();
  const double bytes = sizes_->bytes_of(sent.mask()) - sizes_->bytes_of(reader.asked.mask()) + part_less;
  return ", which adds " + std::to_string(std::lround(bytes)) + " bytes to a sample that others asked for";
}

}  // namespace sft::udp
