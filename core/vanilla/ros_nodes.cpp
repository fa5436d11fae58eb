#include "core/vanilla/ros_nodes.h"

#include <algorithm>

#include "core/names/names.h"

namespace sft::core {

std::pair<RosNodes::Prefix, RosNodes::EntityId> RosNodes::parts_of(const Guid& guid) {
  Prefix prefix{};
  EntityId entity{};
  std::copy_n(guid.begin(), prefix.size(), prefix.begin());
  std::copy_n(guid.begin() + prefix.size(), entity.size(), entity.begin());
  return {prefix, entity};
}

RosNodes::Participant RosNodes::compact(std::uint64_t writer, const Prefix& prefix,
                                        const ReceivedEntities& said) {
  Participant participant{.writer = writer, .guid_bytes = said.guid_bytes};
  for (const ParticipantEntities::Node& node : said.entities.nodes) {
    if (!fault_of_namespace(node.name_space).empty() || !fault_of_node(node.name).empty()) continue;
    const auto number = static_cast<std::uint32_t>(participant.nodes.size());
    participant.nodes.push_back((node.name_space == "/" ? "" : node.name_space) + "/" + node.name);
    for (const auto* endpoints : {&node.readers, &node.writers}) {
      for (const Guid& endpoint : *endpoints) {
        const auto [of, entity] = parts_of(endpoint);
        if (of == prefix) participant.endpoints.emplace_back(entity, number);
      }
    }
  }
  std::ranges::sort(participant.endpoints);
  participant.endpoints.shrink_to_fit();
  return participant;
}

std::size_t RosNodes::bytes_of(const Participant& participant) {
  std::size_t bytes = participant.endpoints.size() * sizeof participant.endpoints.front();
  for (const std::string& node : participant.nodes) bytes += sizeof node + node.size();
  return bytes;
}

bool RosNodes::note(std::uint64_t writer, const Guid& participant, const ReceivedEntities& said) {
  const Prefix prefix = parts_of(participant).first;
  if (parts_of(said.entities.participant).first != prefix) return false;
  const auto known = participants_.find(prefix);
  if (known == participants_.end() && participants_.size() >= participants_max) return false;
  Participant now = compact(writer, prefix, said);
  if (known != participants_.end()) bytes_ -= bytes_of(known->second);
  if (bytes_ + bytes_of(now) > bytes_max) now = {.writer = writer, .guid_bytes = said.guid_bytes};
  bytes_ += bytes_of(now);
  if (known != participants_.end() && known->second == now) return false;
  participants_.insert_or_assign(prefix, std::move(now));
  return true;
}

bool RosNodes::forget(std::uint64_t writer) {
  const auto is_its = [&](const auto& item) { return item.second.writer == writer; };
  const auto its = std::ranges::find_if(participants_, is_its);
  if (its == participants_.end()) return false;
  bytes_ -= bytes_of(its->second);
  participants_.erase(its);
  return true;
}

std::string_view RosNodes::node_of(const Guid& endpoint) const {
  const auto [prefix, entity] = parts_of(endpoint);
  const auto participant = participants_.find(prefix);
  if (participant == participants_.end()) return {};
  const auto& endpoints = participant->second.endpoints;
  const auto own =
      std::ranges::lower_bound(endpoints, entity, {}, [](const auto& item) { return item.first; });
  if (own == endpoints.end() || own->first != entity) return {};
  return participant->second.nodes[own->second];
}

bool RosNodes::uses(GuidBytes guid_bytes) const {
  return std::ranges::any_of(participants_,
                             [&](const auto& item) { return item.second.guid_bytes == guid_bytes; });
}

}  // namespace sft::core
