#include "core/node/topics.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/control/described_type.h"
#include "core/names/names.h"
#include "core/node/misspelt_topics.h"
#include "sft/detail/type_shape.h"

namespace sft::core {

namespace {

constexpr std::size_t topics_named_max = 10;

Error unknown_topic(std::string_view topic, const std::vector<const TableEntry*>& entries,
                    std::uint32_t domain) {
  std::set<std::string_view> names;
  for (const TableEntry* entry : entries) names.insert(entry->endpoint.topic);
  std::string message =
      "nobody publishes or subscribes to " + in_quotes(topic) + " in domain " + std::to_string(domain) + "; ";
  if (names.empty()) return {Errc::unavailable, message + "no other topics were seen there either"};
  message += "topics that were seen: ";
  std::size_t n = 0;
  for (const std::string_view name : names) {
    if (n == topics_named_max) break;
    message += (n++ == 0 ? "" : ", ") + std::string(name);
  }
  if (n < names.size()) message += ", and " + std::to_string(names.size() - n) + " more";
  std::string similar;
  for (const std::string_view name : names) {
    if (is_similar_topic(topic, name)) similar += (similar.empty() ? "" : " or ") + in_quotes(name);
  }
  if (!similar.empty()) message += "; did you mean " + similar + "?";
  return {Errc::unavailable, message};
}

/// Returns the first type that an endpoint describes, or an error if another endpoint has a different
/// definition of the type.
Result<DynamicType> common_type(const std::vector<const Endpoint*>& endpoints) {
  std::optional<DynamicType> type;
  const Endpoint* first = nullptr;
  Error error;
  for (const Endpoint* e : endpoints) {
    if (first != nullptr && e->type_hash == first->type_hash && e->type_name == first->type_name) continue;
    const Result<DynamicType> described = described_type(*e);
    if (!described) {
      error = described.error();
    } else if (first == nullptr) {
      first = e;
      type = *described;
    } else {
      const std::string difference = detail::first_difference(type->type(), described->type());
      return fail(Errc::type_mismatch, "topic '" + e->topic + "' has several types: node '" + first->node +
                                           "' has " + first->type_name + ", node '" + e->node + "' has " +
                                           e->type_name +
                                           (e->type_name == first->type_name ? " (" + difference + ")" : ""));
    }
  }
  if (!type) return tl::unexpected(error);
  return *type;
}

}  // namespace

Result<DynamicType> type_of(std::string_view topic, const std::vector<const TableEntry*>& entries,
                            std::uint32_t domain) {
  std::vector<const Endpoint*> writers;
  std::vector<const Endpoint*> readers;
  for (const TableEntry* entry : entries) {
    const Endpoint& e = entry->endpoint;
    if (e.topic == topic) (e.role == Role::writer ? writers : readers).push_back(&e);
  }
  if (!writers.empty()) return common_type(writers);
  if (!readers.empty()) return common_type(readers);
  return tl::unexpected(unknown_topic(topic, entries, domain));
}

std::vector<TopicInfo> topics_of(const std::vector<TableEntry>& entries) {
  using TypeId = std::pair<std::string, std::uint64_t>;
  std::map<std::string, std::map<TypeId, TopicInfo::Type>> found;
  for (const TableEntry& entry : entries) {
    const Endpoint& e = entry.endpoint;
    TopicInfo::Type& type = found[e.topic][{e.type_name, e.type_hash}];
    type.name = e.type_name;
    type.hash = e.type_hash;
    const bool writes = e.role == Role::writer;
    (writes ? type.publishers : type.subscribers).push_back(e.node);
    (writes ? type.offered : type.requested).push_back(e.qos);
    if (type.type) continue;
    if (const Result<DynamicType> described = described_type(e)) type.type = *described;
  }
  std::vector<TopicInfo> topics;
  for (auto& [name, types] : found) {
    TopicInfo& topic = topics.emplace_back();
    topic.name = name;
    for (auto& [id, type] : types) topic.types.push_back(std::move(type));
  }
  return topics;
}

}  // namespace sft::core
